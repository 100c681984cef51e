"""Nodes of the user's own beside the robot's: each fails alone, and may spin in a callback."""

from __future__ import annotations

import os
import re
import sys
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.node import Node

import tests.contract.textbook as textbook
from archo_tui.base.errors import ArchoError
from archo_tui.base.safe_text import HIDDEN
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.snapshot import Life
from archo_tui.session.session import Session
from archo_tui.user_code.file import ProgramFile
from archo_tui.user_code.usage import Usage, of_process, usage_text
from tests.support import chosen
from tests.support.console import console
from tests.support.waiting import wait_until
from tests.user_code.support import running, spinning, texts, written


class Bad(Node):
    """Raises in its first callback."""

    def __init__(self, **options: Any) -> None:
        super().__init__("bad", **options)
        self.create_timer(0.01, self.explode)

    def explode(self) -> None:
        raise ZeroDivisionError("boom")


class Good(Node):
    """Ticks on."""

    def __init__(self, **options: Any) -> None:
        super().__init__("good", **options)
        self.count = 0
        self.create_timer(0.01, self.tick)

    def tick(self) -> None:
        self.count += 1


def test_a_crash_is_an_event_and_the_others_go_on() -> None:
    with running(node_makers=(Bad, Good), only=False) as session:
        wait_until(lambda: "crashed: ZeroDivisionError: boom" in texts(session))
        (event,) = (event for event in session.robot.snapshot.events if event.source == "bad")
        assert event.level == "ERROR"
        bad, good = session.host.nodes
        assert bad.state.life is Life.CRASHED
        assert "in explode" in bad.state.traceback
        seen = good.node.count  # type: ignore[attr-defined]
        wait_until(lambda: good.node.count > seen)  # type: ignore[attr-defined]
        wait_until(lambda: [n.name for n in session.robot.snapshot.nodes] == ["/good"])


def test_none_of_archos_own_is_made_beside_a_programs_node_of_its_name() -> None:
    """A slow program may make it between the look for such nodes and the making of ARCHO's own."""
    with running(node_makers=(Good,), only=False) as session:
        program: Any = SimpleNamespace(is_stopping=False)
        assert session.host._make_way(program, "/late") == ""
        session.host.add(partial(Node, "late"))
        assert session.host.names() == ["/good"]
        wait_until(lambda: [n.name for n in session.robot.snapshot.nodes] == ["/good"])


CALLER = """
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger


class Caller(Node):
    def __init__(self):
        super().__init__("caller")
        group = {group}
        self.create_service(Trigger, "ping", self.ping, callback_group=group)
        self.client = self.create_client(Trigger, "ping", callback_group=group)
        self.count = 0
        self.create_timer(0.1, self.tick)

    def ping(self, request, response):
        response.success = True
        return response

    def tick(self):
        self.count += 1
        self.get_logger().warning(f"tick {{self.count}} begins")
        future = self.client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self, future{given})
        self.get_logger().warning(f"tick {{self.count}} ends: {{future.result().success}}")


def main():
    rclpy.init()
    {spin}
"""
OTHER = "MutuallyExclusiveCallbackGroup()"
SPIN = "rclpy.spin(Caller())"
OWN_EXECUTORS = ("SingleThreadedExecutor()", "MultiThreadedExecutor()")


def hosting(
    group: str = OTHER, spin: str = SPIN, given: str = "", name: str = "caller"
) -> AbstractContextManager[Session]:
    text = CALLER.format(group=group, spin=spin, given=given).replace('"caller"', f'"{name}"')
    return running(written(f"{name}.py", text))


def times(session: Session, text: str) -> int:
    return sum(event.count for event in session.robot.snapshot.events if event.text == text)


def test_a_node_that_spins_in_a_callback_ticks_on(here: Path) -> None:
    with hosting() as session:
        wait_until(lambda: "tick 4 ends: True" in texts(session))


def test_with_an_executor_of_its_own_it_ends_and_the_line_is_said(here: Path) -> None:
    for number, executor in enumerate(OWN_EXECUTORS):
        name = f"caller_{number}"
        with hosting(spin=f"rclpy.spin(Caller(), {executor})", name=name) as session:
            wait_until(lambda: "tick 1 ends: True" in texts(session))
            (event,) = (e for e in session.robot.snapshot.events if "executor" in e.text)
            assert (event.level, event.source) == ("WARN", name)
            assert event.text == (
                f"{name}.py:26: takes {name} from the executor of main(), which calls "
                f"nothing of {name} any more: pass executor=self.executor, "
                "in: rclpy.spin_until_future_complete(self, future)"
            )
            # what an executor of threads waited for before may be called once more
            last = 2 if "Multi" in executor else 1
            assert f"tick {last + 1} begins" not in texts(session)
            assert event.count == 1


def test_given_the_executor_of_main_it_ticks_on(here: Path) -> None:
    spin = "rclpy.spin(Caller(), SingleThreadedExecutor())"
    with hosting(spin=spin, given=", executor=self.executor") as session:
        wait_until(lambda: "tick 4 ends: True" in texts(session))
        assert not [text for text in texts(session) if "of main()" in text]


@pytest.mark.real_time
def test_stopping_a_node_ends_the_spin_that_would_never_end(here: Path) -> None:
    """The answer comes to the callback group that the timer's callback holds."""
    for spin in (SPIN, *(f"rclpy.spin(Caller(), {executor})" for executor in OWN_EXECUTORS)):
        with hosting(group="None", spin=spin) as session:
            wait_until(lambda: "tick 1 begins" in texts(session))
            outcome = session.host.stop_node("/caller")
            assert outcome == (Code.DONE, "/caller stopped"), spin
            assert session.host.start_node("/caller").ok
            wait_until(lambda: times(session, "tick 1 begins") == 2)
            assert "tick 1 ends: True" not in texts(session)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells it")
@pytest.mark.parametrize(
    ("before", "said"),
    [
        (None, "process 7: 2.5 s of processor time, 61 MB"),
        (Usage(2.2, 0, "process 7"), "process 7: 15% of one core, 2.5 s of processor time, 61 MB"),
        (
            Usage(9.0, 0, "process 6"),
            "process 7: 2.5 s of processor time, 61 MB",
        ),  # It was restarted.
    ],
)
def test_the_share_is_of_the_time_since_the_last_look(before: Usage | None, said: str) -> None:
    assert usage_text(before, Usage(2.5, 61_000_000, "process 7"), 2.0) == said


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells it")
def test_a_process_that_has_ended_takes_nothing() -> None:
    assert of_process(2**22 + 1) is None  # More than Linux gives.


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells it")
async def test_the_dialog_of_a_program_shows_what_it_takes(here: Path) -> None:
    file = spinning("busy", "node.create_timer(0.1, lambda: sum(range(100_000)))")
    async with console(node_files=[file], only=True, wait=False, size=(120, 36)) as op:
        await op.until("● busy")
        await op.press("5", "enter")
        where = "process " if chosen.ENGINE == "ros2" else "1 thread of this process: "
        await op.until(f"takes       {where}")
        await op.until("% of one core")


LISTINGS = Path(textbook.__file__).parent
GREETS = 'node.create_timer(0.5, lambda: node.get_logger().warning("hello from my own node"))'


async def test_ones_own_node_runs_beside_the_robots_and_what_it_prints_is_an_event(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async with console(node_files=[spinning("greeter", f"print('\\x1b[31m')\n{GREETS}")]) as op:

        def printed() -> list[str]:
            events = op.app.view.snapshot.events
            return [event.text for event in events if event.source == "greeter stdout"]

        await op.until(printed)
        assert printed() == [f"{HIDDEN}[31m"]
        await op.until("hello from my own node")
        await op.until("● greeter")
        await op.until("warnings + your commands and nodes")
        await op.press("r")
        await op.until("reset encoder: Encoder reset to zero")
    assert "\x1b[31m" not in capsys.readouterr().out


async def test_a_textbooks_node_takes_the_place_of_the_robots_of_its_name() -> None:
    only = chosen.ENGINE == "ros2"  # there is one type a topic in one process, on DDS
    listing = LISTINGS / "battery_publisher.py"
    async with console(node_files=[listing], only=only, wait=False) as op:
        # On a busy machine it may be empty by now, which the listing does not end at.
        await op.until(lambda: op.app.view.snapshot.battery.received)
        await op.until("charging: not reported")
        names = op.session.host.names()
        others = [] if only else ["/dashboard", "/motor_controller"]
        assert sorted(names) == ["/battery_monitor", *others]


@pytest.mark.real_time
async def test_a_textbooks_motor_shows_its_way_and_says_what_it_lacks_in_words() -> None:
    listing = LISTINGS / "move_action_server.py"
    async with console(node_files=[listing], only=True, wait=False) as op:
        await op.until(lambda: "move_to_shelf" in op.app.view.snapshot.offered)
        await op.press("g", "5", "enter")
        # Each state lasts half a second: on a busy machine one may be missed.
        left, way = r"(12|9|6|3)\.0 m left of 15\.0 m", r"   (20|40|60|80) %"
        await op.until(lambda: re.search(left, op.text) and re.search(way, op.text))
        assert "no node publishes motor_status" in op.text
        await op.until("ARRIVED")


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("import nosuchpackage\n", "line 1: ModuleNotFoundError: ", "nosuchpackage"),
        (
            "import no_such_msgs.msg\n",
            "line 1: no package no_such_msgs: ",
            "--interfaces DIR takes",
        ),
        (
            "from archo_interfaces.msg import BatteryState\n",
            "line 1: no msg BatteryState in archo_interfaces ",
            "(nearest: BatteryStatus)",
        ),
        (
            "from rclpy.node import Node\nclass X(Node):\n    def __init__(self):\n"
            "        super().__init__('x')\n        self.create_timer('fast', print)\n",
            "line 5: ValueError: ",
            "could not convert string to float",
        ),
    ],
)
def test_a_file_that_does_not_run_is_one_line(text: str, line: str, said: str, here: Path) -> None:
    with running(written("my_node.py", text)) as session:
        (program,) = session.host.programs
        wait_until(lambda: program.state.life is Life.CRASHED)
        assert program.state.error.startswith(line)
        assert said in program.state.error
        assert "\n" not in program.state.error


def test_a_file_that_takes_standard_output_away_takes_it_from_nobody(here: Path) -> None:
    with running(spinning("taker", "import sys\nsys.stdout = None"), only=False):
        assert sys.stdout is not None


@pytest.mark.posix
def test_a_file_that_became_a_pipe_is_one_line_at_once(tmp_path: Path) -> None:
    file = ProgramFile(str(written(tmp_path / "my_node.py", "")))
    file.path.unlink()
    os.mkfifo(file.path)
    with pytest.raises(ArchoError, match=r"my_node\.py: not a regular file"):
        file.compile()
    with pytest.raises(ArchoError, match=r"my_node\.py: not a regular file"):
        ProgramFile(str(file.path))
    with pytest.raises(ArchoError, match=r"nowhere\.py: no such file"):
        ProgramFile("nowhere.py")
