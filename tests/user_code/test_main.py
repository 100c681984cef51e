"""What `main()` makes is what runs, however it makes it; the chapter's harder exercise, too."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from archo_tui.robot.state.snapshot import Life
from archo_tui.session.session import Session
from tests.support import chosen, warm
from tests.support.plain import typing
from tests.support.waiting import wait_until
from tests.user_code.support import life, running, states, texts, written

pytestmark = [pytest.mark.real_time, pytest.mark.posix]


SHARE = Path(__file__).parent.parent / "share"
HEAD = """
import sys
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter


class Talker(Node):
    def __init__(self, name="nobody", **options):
        super().__init__(name, **options)


class Other(Node):
    def __init__(self):
        super().__init__("other")


"""


def up(session: Session) -> list[str]:
    return sorted(name for name, state in states(session).items() if state.life is Life.UP)


@pytest.mark.parametrize(
    ("program", "nodes"),
    [
        ("programs/main_has_branches", ["/motor_sim"]),
        ("programs/node_made_in_main", ["/battery_monitor"]),
    ],
)
def test_a_program_of_a_course_makes_what_its_main_makes(program: str, nodes: list[str]) -> None:
    with running(SHARE / f"{program}.py") as session:
        wait_until(lambda: up(session) == nodes)


MADE = {
    "an App": """
class App:
    def __init__(self):
        rclpy.init()
        self.node = Talker("talker")

    def run(self):
        rclpy.spin(self.node)


if __name__ == "__main__":
    App().run()
""",
    "asyncio": """
import asyncio


async def main():
    rclpy.init()
    node = Talker("talker")
    while rclpy.ok():
        rclpy.spin_once(node, timeout_sec=0.01)
        await asyncio.sleep(0.01)


if __name__ == "__main__":
    asyncio.run(main())
""",
    "a script": """
rclpy.init()
rclpy.spin(Talker("talker"))
""",
}


@pytest.mark.parametrize("made", MADE)
def test_what_is_made_by(made: str, here: Path) -> None:
    file = written("program.py", HEAD + MADE[made])
    with running(file) as session:
        wait_until(lambda: up(session) == ["/talker"])


def test_a_file_without_main_has_its_node_classes_made_each_alone(here: Path) -> None:
    file = written("program.py", HEAD)
    with running(file) as session:
        wait_until(lambda: up(session) == ["/nobody", "/other"])


def test_a_main_that_sends_a_goal_sends_it() -> None:
    with running(SHARE / "programs" / "main_sends_a_goal.py", only=False) as session:
        wait_until(lambda: "/sender" in states(session))
        wait_until(lambda: life(session, "/sender") is Life.ENDED)
        wait_until(lambda: any("Moving to shelf 3" in text for text in texts(session)))


ARGUMENTS = HEAD + "print('words', sys.argv[1:], len(sys.argv), [*sys.argv][1:2])\n"


def test_a_program_has_the_arguments_behind_the_dashes_and_no_other(here: Path) -> None:
    (here / "first.py").write_text(ARGUMENTS)
    (here / "program.py").write_text(ARGUMENTS)
    words = ["--only", "--node", "first.py", "--node", "program.py", "--plain", "--no-remote"]
    words += ["--engine", chosen.ENGINE, "--", "--speed", "3"]
    done = subprocess.run(
        warm.python("-m", "archo_tui", *words),
        input="",
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "ROS_DOMAIN_ID": str(chosen.next_domain())},
    )
    assert done.returncode == 0, done.stderr
    own = [line.partition(" INFO ")[2] for line in done.stdout.splitlines() if "words" in line]
    words = ["first stdout: words [] 1 []", "program stdout: words ['--speed', '3'] 3 ['--speed']"]
    assert own == words


def test_a_copy_has_another_name_and_is_copied_again(here: Path) -> None:
    with running(SHARE / "programs" / "name_given_in_main.py") as session:
        wait_until(lambda: up(session) == ["/talker"])
        assert session.host.copy_node("/talker").text == "/talker_2 started"
        wait_until(lambda: up(session) == ["/talker", "/talker_2"])
        assert session.host.copy_node("/talker_2").text == "/talker_3 started"
        wait_until(lambda: up(session) == ["/talker", "/talker_2", "/talker_3"])
        assert session.host.stop_node("/talker_2").ok
        assert session.host.start_node("/talker_2").ok
        wait_until(lambda: up(session) == ["/talker", "/talker_2", "/talker_3"])


@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="there Python prints the traceback")
def test_an_error_of_main_is_told_at_once_though_its_threads_run_on(here: Path) -> None:
    file = written(
        "threads.py",
        HEAD
        + """
import threading


def main():
    rclpy.init()
    node = Talker("talker")
    threading.Thread(target=rclpy.spin, args=(node,)).start()
    raise ValueError("no serial port")
""",
    )
    with running(file) as session:
        told = "ValueError: no serial port"
        wait_until(lambda: any(told in t and "run on" in t for t in texts(session)))


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
