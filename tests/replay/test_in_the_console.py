"""A recording that is played in the terminal of the console, which goes on."""

from __future__ import annotations

import shutil
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from archo_tui.keyed_app import HELD
from archo_tui.paths import state_file
from tests.support import chosen
from tests.support.console import LONG
from tests.support.terminal import Terminal

pytestmark = pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="the engine plays no part in it: one is enough"
)
CRASHES = """
from pathlib import Path

import rclpy
from rclpy.node import Node


class Fragile(Node):
    def __init__(self):
        super().__init__("fragile")
        self.create_timer(0.1, self.look)

    def look(self):
        if Path("crash").exists():
            raise RuntimeError("a wheel came off")
"""


@pytest.fixture
def playing(drive: Path, terminals: list[Terminal]) -> Callable[..., Terminal]:
    """A console on its way to shelf 7, in whose terminal a recording is played."""

    def begin(*words: str) -> Terminal:
        shutil.copytree(drive, state_file("recordings") / drive.name, dirs_exist_ok=True)
        terminal = Terminal(*words, "--ros-args", *LONG)
        terminals.append(terminal)
        terminal.until("max_speed")
        terminal.write("7\r")
        terminal.until("MOVING")
        terminal.write("\x10recordings\r")
        terminal.until("y copy its command")
        terminal.read_for(2 * HELD)  # The same key again is taken for a held one.
        terminal.write("\r")
        terminal.until("REPLAY")
        terminal.until("Speed")
        terminal.output = b""
        return terminal

    return begin


def test_q_leads_back_to_the_console(playing: Callable[..., Terminal]) -> None:
    terminal = playing()
    terminal.write("q")
    terminal.until("MOVING to 7")
    assert b"REPLAY" not in terminal.output[terminal.output.rfind(b"\x1b[?1049h") :]
    terminal.write("\x18")
    terminal.until("STOP: confirmed")
    terminal.write("\x11q")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()


def test_stop_is_for_the_robot_and_leads_back(playing: Callable[..., Terminal]) -> None:
    terminal = playing()
    terminal.write("\x18")
    terminal.until("STOP: confirmed")
    terminal.until("shelf 7 aborted")


def test_a_grave_alarm_leads_back(
    playing: Callable[..., Terminal], here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / "fragile.py").write_text(CRASHES)
    terminal = playing("--node", "fragile.py")
    (here / "crash").touch()
    terminal.until("NODE CRASHED")
    terminal.until("MOVING to 7")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_the_end_of_the_console_ends_it_and_gives_the_terminal_back(
    playing: Callable[..., Terminal], number: signal.Signals
) -> None:
    terminal = playing()
    terminal.kill(number)
    assert terminal.exit_code() == 128 + number
    assert terminal.is_as_before()
