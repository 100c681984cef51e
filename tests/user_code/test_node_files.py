"""Nodes of the user's own, from files, beside the robot's or in their place."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

import tests.contract.textbook as textbook
from archo_tui.base.errors import ArchoError
from archo_tui.base.safe_text import HIDDEN
from archo_tui.robot.state.snapshot import Life
from archo_tui.user_code.file import ProgramFile
from tests.support import chosen
from tests.support.console import console
from tests.support.waiting import wait_until
from tests.user_code.support import running, spinning, written

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
