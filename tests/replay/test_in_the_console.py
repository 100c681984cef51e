"""A recording that is played in the terminal of the console, which goes on."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import sys
import termios
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from archo_tui.base.handover import CONSOLE_SOCKET, STOP
from archo_tui.base.paths import config_file, state_file
from archo_tui.recordings.replay.station import ConsoleStops
from archo_tui.screen.keyed_app import HELD
from tests.support import chosen
from tests.support.console import LONG
from tests.support.terminal import Terminal
from tests.support.waiting import wait_until

pytestmark = pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="the engine plays no part in it: one is enough"
)
DEPOT = Path(__file__).parent.parent / "share" / "depot_interfaces"
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
def listed(drive: Path, terminals: list[Terminal]) -> Callable[..., Terminal]:
    """A console that lists its recording; keys may have been typed before."""

    def begin(*words: str, typed: str = "", until: str = "max_speed") -> Terminal:
        shutil.copytree(drive, state_file("recordings") / drive.name, dirs_exist_ok=True)
        terminal = Terminal(*words, "--ros-args", *LONG)
        terminals.append(terminal)
        terminal.until("max_speed")
        terminal.write(typed)
        terminal.until(until)
        terminal.write("\x10recordings\r")
        terminal.until("y copy its command")
        terminal.read_for(2 * HELD)  # The same key again is taken for a held one.
        return terminal

    return begin


@pytest.fixture
def playing(listed: Callable[..., Terminal]) -> Callable[..., Terminal]:
    """A console on its way to shelf 7, in whose terminal a recording is played."""

    def begin(*words: str) -> Terminal:
        terminal = listed(*words, typed="7\r", until="MOVING")
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
    terminal.read_for(1.0)
    terminal.output = b""
    terminal.resize(40, 10)
    terminal.until(lambda: "^x STOP" in terminal.text)  # Of the live robot, at any size.
    terminal.write("\x18")
    terminal.until("✗ STOPPED")
    terminal.resize(120, 36)  # There is room for what was said meanwhile.
    terminal.until("STOP: confirmed")
    terminal.until("shelf 7 aborted")


def test_a_keymap_saved_meanwhile_changes_no_key_of_stop(
    listed: Callable[..., Terminal],
) -> None:
    terminal = listed(typed="7\r", until="MOVING")
    config_file("keymap.yaml").parent.mkdir(parents=True, exist_ok=True)
    config_file("keymap.yaml").write_text("stop: f9\n")
    terminal.write("\r")
    terminal.until("REPLAY")
    terminal.until("Speed")
    terminal.write("\x18")
    terminal.until("STOP: confirmed")


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits another process")
def test_where_none_can_begin_the_screen_says_so_and_goes_on(
    listed: Callable[..., Terminal],
) -> None:
    import resource

    terminal = listed()
    limits = resource.prlimit(terminal.pid, resource.RLIMIT_NOFILE)
    resource.prlimit(terminal.pid, resource.RLIMIT_NOFILE, (3, limits[1]))
    terminal.write("\r")
    terminal.until("not played: Too many open files")
    resource.prlimit(terminal.pid, resource.RLIMIT_NOFILE, limits)
    terminal.read_for(2 * HELD)
    terminal.write("\x18")
    terminal.until("STOP: confirmed")


def test_a_stop_is_sent_to_the_console_as_it_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    console, its = socket.socketpair()
    with console, its:
        monkeypatch.setenv(CONSOLE_SOCKET, str(its.fileno()))
        ConsoleStops().register()
        assert console.recv(1) == STOP


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_the_end_of_the_console_ends_it_and_gives_the_terminal_back(
    playing: Callable[..., Terminal], number: signal.Signals
) -> None:
    terminal = playing()
    terminal.kill(number)
    assert terminal.exit_code() == 128 + number
    assert terminal.is_as_before()


def test_keys_typed_as_it_opens_and_behind_its_end_reach_no_robot(
    listed: Callable[..., Terminal],
) -> None:
    terminal = listed()
    terminal.write("\r7\r")
    terminal.until("Speed")
    terminal.output = b""
    terminal.write("q" * 3)
    terminal.until("goal yet")
    terminal.until("The replay is over: press the key again.")
    terminal.read_for(3 * HELD)
    assert b"to 7" not in terminal.output
    terminal.write("\x11")
    assert terminal.exit_code() == 0


def test_a_grave_alarm_leads_back(playing: Callable[..., Terminal], here: Path) -> None:
    (here / "fragile.py").write_text(CRASHES)
    terminal = playing("--node", "fragile.py")
    (here / "crash").touch()
    terminal.until("NODE CRASHED")
    terminal.until("\x07")


@pytest.mark.parametrize("number", [signal.SIGTSTP, signal.SIGSTOP])
def test_one_that_is_suspended_leads_back_and_a_stop_pressed_meanwhile_is_sent(
    playing: Callable[..., Terminal], number: signal.Signals
) -> None:
    terminal = playing()
    os.kill(_replay_of(terminal), number)
    terminal.write("\x18")
    terminal.until("STOP: confirmed")


def test_stopped_with_its_console_it_goes_on_whatever_a_shell_set(
    playing: Callable[..., Terminal],
) -> None:
    terminal = playing()
    both, raw = (_replay_of(terminal), terminal.pid), terminal.settings()
    for process in both:
        os.kill(process, signal.SIGSTOP)
    terminal.change_settings(terminal.before)
    for process in both:
        os.kill(process, signal.SIGCONT)
    terminal.until(lambda: terminal.settings() == raw)
    terminal.write("\x18")
    terminal.until("STOP: confirmed")


@pytest.mark.parametrize("hangs", [False, True], ids=["slow", "hanging"])
def test_a_stop_pressed_as_the_console_ends_is_sent(
    playing: Callable[..., Terminal], hangs: bool
) -> None:
    terminal = playing()
    replay = _replay_of(terminal)
    with _held(replay) as is_continued:
        terminal.kill(signal.SIGTERM)
        terminal.until(is_continued)
        terminal.write("\x18")
        if hangs:
            assert terminal.exit_code() == 128 + signal.SIGTERM
    if not hangs:
        os.kill(replay, signal.SIGCONT)
        assert terminal.exit_code() == 128 + signal.SIGTERM
    lines = map(json.loads, state_file("journal.jsonl").read_text().splitlines())
    assert ("stop", "done") in [(line.get("verb"), line.get("code")) for line in lines]


def test_a_console_that_is_left_as_one_opens_does_not_show_it(
    listed: Callable[..., Terminal],
) -> None:
    terminal = listed()
    terminal.output = b""
    terminal.write("\r\x11")
    assert terminal.exit_code() == 0
    assert b"Speed" not in terminal.output


def test_one_that_is_killed_leads_back_and_says_so(playing: Callable[..., Terminal]) -> None:
    terminal = playing()
    os.kill(_replay_of(terminal), signal.SIGKILL)
    terminal.until("the replay broke off")
    terminal.write("\x18")
    terminal.until("STOP: confirmed")


def test_one_that_cannot_be_read_leaves_the_screen_whole(listed: Callable[..., Terminal]) -> None:
    terminal = listed()
    shutil.rmtree(state_file("recordings"))
    terminal.write("\r")
    terminal.until("not played")
    terminal.until(lambda: "6 Events" in terminal.text.partition("no recordings in")[2])


def test_a_restart_behind_one_leaves_the_terminal_to_the_next_process(
    playing: Callable[..., Terminal], here: Path
) -> None:
    shutil.copytree(DEPOT, here / "own")
    terminal = playing("--interfaces", "own")
    with (here / "own/msg/CellState.msg").open("a") as file:
        file.write("bool more\n")
    terminal.until("the console restarts")
    assert not terminal.settings()[3] & termios.ECHO  # Else ctrl+c would be a signal.
    terminal.write("\x18")
    terminal.until("STOP: confirmed")


def _replay_of(terminal: Terminal) -> int:
    """Return the process that plays in a terminal."""
    tasks = Path(f"/proc/{terminal.pid}/task").glob("*/children")
    (found,) = [int(child) for task in tasks for child in task.read_text().split()]
    return found


@contextmanager
def _held(process: int) -> Iterator[Callable[[], bool]]:
    """Hold a process, also if it is continued; yield what tells whether it was."""
    is_continued, is_over = threading.Event(), threading.Event()
    status = Path(f"/proc/{process}/status")

    def hold() -> None:
        with suppress(OSError):  # It was killed.
            os.kill(process, signal.SIGSTOP)
            wait_until(lambda: "State:\tT" in status.read_text())
            while not is_over.wait(0.001):
                if "State:\tT" not in status.read_text():
                    os.kill(process, signal.SIGSTOP)
                    is_continued.set()

    holding = threading.Thread(target=hold)
    holding.start()
    try:
        yield is_continued.is_set
    finally:
        is_over.set()
        holding.join()
