"""What a node or program that runs here takes of the machine."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from archo_tui.user_code.usage import Usage, of_process, usage_text
from tests.support import chosen
from tests.support.console import console

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells it")

BUSY = """
import rclpy
from rclpy.node import Node

class Busy(Node):
    def __init__(self):
        super().__init__("busy")
        self.create_timer(0.1, lambda: sum(range(100_000)))

def main():
    rclpy.init()
    rclpy.spin(Busy())

main()
"""


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


def test_a_process_that_has_ended_takes_nothing() -> None:
    assert of_process(2**22 + 1) is None  # More than Linux gives.


async def test_the_dialog_of_a_program_shows_what_it_takes(tmp_path: Path) -> None:
    file = tmp_path / "busy.py"
    file.write_text(BUSY)
    async with console(node_files=[file], only=True, wait=False, size=(120, 36)) as op:
        await op.until("● busy")
        await op.press("5", "enter")
        where = "process " if chosen.ENGINE == "ros2" else "1 thread of this process: "
        await op.until(f"takes       {where}")
        await op.until("% of one core")
