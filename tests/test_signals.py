"""The process in a real terminal: signals and keys end it in order, on each engine."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import sys
import termios
import time
from typing import Any

import pytest

from tests.support import chosen
from tests.support.waiting import DEADLINE


class Terminal:
    """archo-tui in a pseudo terminal."""

    def __init__(self, *words: str) -> None:
        self.output = b""
        self._master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 36, 120, 0, 0))
        self._slave = slave
        self.before = termios.tcgetattr(slave)
        self.pid = os.fork()
        if self.pid == 0:
            os.setsid()
            for fd in (0, 1, 2):
                os.dup2(slave, fd)
            os.environ |= {
                "TERM": "xterm-256color",
                "ROS_DOMAIN_ID": str(chosen.next_domain()),
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF",
            }
            command = [sys.executable, "-m", "archo_tui", "--engine", chosen.ENGINE, *words]
            os.execv(sys.executable, command)

    def until(self, wanted: bytes) -> None:
        """Read until the text has been drawn."""
        end = time.monotonic() + 2 * DEADLINE
        while wanted not in self.output:
            assert time.monotonic() < end, self.output[-3000:]
            ready, _, _ = select.select([self._master], [], [], 0.1)
            if ready:
                self.output += os.read(self._master, 65536)

    def write(self, keys: bytes) -> None:
        os.write(self._master, keys)

    def exit_code(self) -> int:
        """Wait for the end."""
        end = time.monotonic() + 2 * DEADLINE
        while True:
            ready, _, _ = select.select([self._master], [], [], 0.01)
            if ready:
                self.output += os.read(self._master, 65536)
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                return os.waitstatus_to_exitcode(status)
            assert time.monotonic() < end, "the process hangs"

    def settings(self) -> list[Any]:
        return termios.tcgetattr(self._slave)

    def close(self) -> None:
        os.close(self._master)
        os.close(self._slave)


@pytest.mark.parametrize("end", ["q", "SIGTERM", "SIGINT", "SIGHUP", "SIGQUIT"])
def test_it_ends_in_order_and_leaves_the_terminal_as_it_was(end: str) -> None:
    terminal = Terminal()
    try:
        terminal.until(b"online")
        if end == "q":
            terminal.write(b"q")
            code = 0
        else:
            number = getattr(signal, end)
            os.kill(terminal.pid, number)
            code = 128 + number
        assert terminal.exit_code() == code
        assert b"Traceback" not in terminal.output
        assert terminal.settings() == terminal.before
        assert b"\x1b[?1049l" in terminal.output  # back on the main screen
        assert b"\x1b[?25h" in terminal.output  # with its cursor
    finally:
        terminal.close()
