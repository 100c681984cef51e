"""The chapter's harder exercise, as its page asks: a cancel at 9 m, typed in `--plain`."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.support.plain import typing
from tests.user_code.support import running

pytestmark = [pytest.mark.real_time, pytest.mark.posix]

TESTS = Path(__file__).parent.parent
PRINTED = (TESTS / "contract/textbook/move_action_server.py").read_text(encoding="utf-8")
PAGE = (TESTS.parent / "docs/chapter.md").read_text(encoding="utf-8")
SERVER = 'self, MoveToShelf, "move_to_shelf", self.execute_callback\n'
TAKES_CANCELS = (
    SERVER,
    'self, MoveToShelf, "move_to_shelf", self.execute_callback,\n'
    "            callback_group=ReentrantCallbackGroup(),\n"
    "            cancel_callback=lambda goal_handle: CancelResponse.ACCEPT,\n",
)
ENDS_CANCELLED = (
    "            feedback.distance_remaining = distance\n",
    "            if goal_handle.is_cancel_requested:\n"
    "                goal_handle.canceled()\n"
    "                return MoveToShelf.Result(success=False, "
    'final_message="Cancelled mid-route")\n'
    "            feedback.distance_remaining = distance\n",
)
IMPORTS = (
    "from rclpy.action import ActionServer\n",
    "from rclpy.action import ActionServer, CancelResponse\n"
    "from rclpy.callback_groups import ReentrantCallbackGroup\n"
    "from rclpy.executors import MultiThreadedExecutor\n"
    "from rclpy.task import Future\n",
)
THREADS = ("rclpy.spin(node)", "rclpy.spin(node, executor=MultiThreadedExecutor())")
AWAITS = (
    (
        "    def execute_callback",
        """    async def pause(self, seconds):
        done = Future()
        timer = self.create_timer(seconds, lambda: done.set_result(True))
        await done
        self.destroy_timer(timer)

    async def execute_callback""",
    ),
    ("time.sleep(0.5)", "await self.pause(0.5)"),
)
MENDED = (IMPORTS, TAKES_CANCELS, ENDS_CANCELLED)


async def exercise(tmp_path: Path, *patches: tuple[str, str]) -> list[str]:
    """Drive the listing with these patches as the page says; return what is said of the goal."""
    text = PRINTED
    for old, new in patches:
        assert old in text
        text = text.replace(old, new)
    file = tmp_path / "move.py"
    file.write_text(text)
    script = re.search(r"printf '(.*)' \| archo-tui --only --node move.py --plain", PAGE)
    assert script is not None
    with running(file) as session:
        async with typing(session.station) as person:
            person.type(script[1].replace(r"\n", "\n"))
            await person.end()
    said = re.findall(r"^[\d:]+ ((?:goal|failed).*)", person.said, re.MULTILINE)
    return [re.sub(r", [\d.]+ s so far.*|, asked .*| in [\d.]+ s$", "", line) for line in said]


BEGINNING = [f"goal MOVING to 3, {left}.0 m left of 15.0 m" for left in (15, 12, 9)]


async def test_as_printed_every_feedback_is_told_and_the_goal_arrives(tmp_path: Path) -> None:
    said = await exercise(tmp_path)
    goes_on = "goal MOVING to 3, 0.0 m left of 15.0 m"  # If the rejection is seen before the end.
    said = [line for line in said if line != goes_on]
    rejected = "failed: cancel: the robot rejected the cancel: the goal continues or has ended"
    arrived = "goal ARRIVED, Arrived at shelf 3, 15.0 m"
    assert sorted(said[-2:]) == sorted([arrived, rejected])
    assert said[:-2] == [
        *BEGINNING,
        *(f"goal CANCELLING, shelf 3, {left}.0 m left" for left in (6, 3, 0)),
    ]
    told = re.search(r"```\n(goal MOVING to 3, 15.0.*?)```", PAGE, re.DOTALL)
    assert told is not None
    assert set(told[1].splitlines()) == set(said)


@pytest.mark.parametrize("how", [(THREADS,), AWAITS], ids=["threads", "await"])
async def test_each_way_of_the_page_to_mend_it_cancels_at_9_m(
    how: tuple[tuple[str, str], ...], tmp_path: Path
) -> None:
    said = await exercise(tmp_path, *MENDED, *how)
    assert said == [*BEGINNING, "goal CANCELLED, Cancelled mid-route, 9.0 m before shelf 3"]
    for _, new in (*MENDED, *how):
        for line in new.strip().splitlines():
            assert line.strip() in PAGE, line
