"""A console that writes down, in order, which STOPs it read and what its robot did."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from tests.support import chosen

ROOT = Path(__file__).parents[2]
# what is written, a word a line: the console has read a STOP or a release; the robot was stopped
# or released, has begun a goal, or has moved
STOP, RELEASE = "STOP", "release"
STOPPED, RELEASED, BEGUN, MOVED = "stopped", "released", "begun", "moved"


def code(path: Path) -> str:
    """Return Python that makes the process in which it runs write its trace there."""
    return (
        f"import sys; sys.path.insert(0, {str(ROOT)!r})\n"
        f"from tests.support.traced import install; install({str(path)!r}, {chosen.ENGINE!r})"
    )


def install(path: str, engine: str) -> None:
    """Write a trace from now on; called before the console starts.

    Args:
        path: The file to write.
        engine: The engine of the console.
    """
    from archo_tui.ros.engine import activate

    activate(engine)
    from archo_bringup.motion import Drive
    from archo_bringup.motor_controller import MotorController

    from archo_tui.console.socket import SocketClient
    from archo_tui.console.typing import Input
    from archo_tui.robot.stop.gate import Stops

    file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    reading = threading.RLock()  # what is read has one order, whatever thread reads it

    def write(word: str) -> None:
        os.write(file, f"{word}\n".encode())

    def traced(owner: Any, name: str, word: str) -> None:
        """Write the word whenever this method is called."""
        method = getattr(owner, name)

        def call(*given: Any) -> Any:
            with reading:
                write(word)
                return method(*given)

        setattr(owner, name, call)

    traced(Stops, "register", STOP)
    traced(MotorController, "emergency_stop", STOPPED)
    traced(MotorController, "release_emergency_stop", RELEASED)
    traced(Drive, "begin", BEGUN)  # a goal was accepted
    traced(Drive, "advance", MOVED)

    take, keep = SocketClient.on_line, Input._keep

    def take_line(client: SocketClient, data: bytes) -> None:
        with reading:
            _write_release(data, write)
            take(client, data)

    def keep_lines(typed: Input, lines: list[bytes]) -> None:
        for line in lines:
            with reading:
                _write_release(line, write)
                keep(typed, [line])

    patched: tuple[Any, Any] = SocketClient, Input
    patched[0].on_line, patched[1]._keep = take_line, keep_lines


def _write_release(line: bytes, write: Callable[[str], None]) -> None:
    if b"release" in line and b"stop" not in line.lower():
        write(RELEASE)


class Trace:
    """The words of a trace, judged one by one."""

    def __init__(self) -> None:
        self.stops = 0  # that were read
        self.moves = 0
        self.is_stopped = False  # the robot
        self.is_final = False  # a STOP was read, and no release behind it
        self._holds = False  # that STOP has reached the robot
        self.fault = ""

    def take(self, words: Iterable[str]) -> None:
        """Judge what was written since."""
        for number, word in enumerate(words):
            if word == STOP:
                self.stops += 1
                self.is_final, self._holds = True, self.is_stopped
            elif word == RELEASE:
                self.is_final = self._holds = False
            elif word == STOPPED:
                self.is_stopped, self._holds = True, self.is_final
            elif word == RELEASED:
                self.is_stopped = False
            elif word in (BEGUN, MOVED):
                self.moves += 1
                if self._holds and not self.fault:
                    self.fault = f"{word}, behind STOP {self.stops}, word {number}"
