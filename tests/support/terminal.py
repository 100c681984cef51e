"""archo-tui as a process in a pseudo terminal."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import sys
import termios
import time
from collections.abc import Callable
from typing import Any

from archo_tui.base.paths import journal_file
from tests.support import chosen, warm
from tests.support.waiting import DEADLINE, wait_until


class Terminal:
    """A terminal that reads, or does not, or is gone."""

    def __init__(
        self,
        *words: str,
        code: str = "",
        ignore_hangup: bool = False,
        controlling: bool = True,
        size: tuple[int, int] = (120, 36),
        term: str = "xterm-256color",
        fresh: bool = False,
        domain: int | None = None,
    ) -> None:
        """`code` is Python to run before the command line is obeyed; `fresh`: before it is loaded.

        Of a terminal that is not `controlling` no signal comes when it hangs up. Without a `domain`
        it has one of its own.
        """
        self.output = b""
        self._master, slave = pty.openpty()
        self.resize(*size)
        self._slave: int | None = slave
        self.before = termios.tcgetattr(slave)
        arguments = ["--engine", chosen.ENGINE, *words]
        environment = {
            "TERM": term,
            "ROS_DOMAIN_ID": str(chosen.next_domain() if domain is None else domain),
            # A program is a process of its own there.
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST" if "--node" in words else "OFF",
        }
        start = f"from archo_tui.cli import main\nsys.exit(main({arguments!r}))"
        program = f"import sys\n{code}\n{start}"
        how = {"controlling": controlling, "ignore_hangup": ignore_hangup}
        self._forked: warm.Forked | None = None
        if warm.is_usable() and not fresh and "--interfaces" not in words:
            self._forked = warm.Forked(slave, "-c", program, environment=environment, **how)
            self.pid = self._forked.pid
            return
        self.pid = os.fork()
        if self.pid == 0:
            warm.move_into(slave, **how)
            os.environ |= environment
            for name in ("COLUMNS", "LINES"):
                os.environ.pop(name, None)
            # readline may have put COLUMNS where only execv sees it
            os.execve(sys.executable, [sys.executable, "-c", program], dict(os.environ))

    def resize(self, width: int, height: int) -> None:
        size = struct.pack("HHHH", height, width, 0, 0)
        fcntl.ioctl(self._master, termios.TIOCSWINSZ, size)

    def read(self, seconds: float = 0.1) -> None:
        """Take what was drawn, if anything comes within that time."""
        ready, _, _ = select.select([self._master], [], [], seconds)
        if ready:
            try:
                self.output += os.read(self._master, 65536)
            except OSError:  # the other end is closed
                time.sleep(0.01)

    def read_for(self, seconds: float) -> None:
        """Take what is drawn in that time."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self.read(left)

    def until(self, wanted: str | Callable[[], object]) -> None:
        """Read until the text has been drawn, or a condition holds."""
        end = time.monotonic() + 2 * DEADLINE
        holds = (lambda: wanted.encode() in self.output) if isinstance(wanted, str) else wanted
        while not holds():
            assert time.monotonic() < end, f"waited for {wanted!r}: {self.text[-3000:]}"
            self.read()

    @property
    def text(self) -> str:
        """What was drawn, without the sequences that move and colour."""
        plain = re.sub(rb"\x1b\[[0-9;?<>=]*[a-zA-Z$]+|\x1b[()][A-Z0-9]", b"", self.output)
        return plain.decode(errors="replace")

    def write(self, keys: str) -> None:
        os.write(self._master, keys.encode())

    def leave_field(self) -> None:
        """Leave the goal's field, where digits are a shelf, for the panels."""
        self.write("\x1b")
        self.until("Panels")

    def kill(self, number: int) -> None:
        os.kill(self.pid, number)

    def exit_code(self, *, reading: bool = True) -> int:
        """Wait for the end."""
        end = time.monotonic() + 2 * DEADLINE
        while True:
            if reading and self._master >= 0:
                self.read(0.01)
            else:
                time.sleep(0.01)
            status = self._status()
            if status is not None:
                before = -1
                while reading and self._master >= 0 and len(self.output) > before:
                    before = len(self.output)
                    self.read(0.0)  # What it drew last.
                return os.waitstatus_to_exitcode(status)
            if time.monotonic() > end:
                self.kill(signal.SIGKILL)
                raise AssertionError(f"the process hangs: {self.text[-2000:]}")

    def _status(self) -> int | None:
        if self._forked is not None:
            return self._forked.status()
        pid, status = os.waitpid(self.pid, os.WNOHANG)
        return status if pid else None

    def settings(self) -> list[Any]:
        assert self._slave is not None
        return termios.tcgetattr(self._slave)

    def change_settings(self, settings: list[Any]) -> None:
        assert self._slave is not None
        termios.tcsetattr(self._slave, termios.TCSANOW, settings)

    def hang_up(self) -> None:
        """The terminal is gone."""
        if self._slave is not None:
            os.close(self._slave)
            self._slave = None
        os.close(self._master)
        self._master = -1

    def is_as_before(self) -> bool:
        """True when settings, screen, cursor and mouse are those from before the start."""
        return (
            self.settings() == self.before
            and self.output.rfind(b"\x1b[?1049l") > self.output.rfind(b"\x1b[?1049h")
            and self.output.rfind(b"\x1b[?25h") > self.output.rfind(b"\x1b[?25l")
            and self.output.rfind(b"\x1b[?1000l") > self.output.rfind(b"\x1b[?1000h")
        )

    def close(self) -> None:
        if self._forked is not None:
            self._forked.close()
        if self._master >= 0:
            os.close(self._master)
        if self._slave is not None:
            os.close(self._slave)


Start = Callable[..., Terminal]  # The fixture `start`.


def entries() -> list[dict[str, Any]]:
    """What the journal has, the oldest first."""
    if not journal_file().exists():
        return []
    return [json.loads(line) for line in journal_file().read_text("utf-8").splitlines()]


def said(kind: str = "") -> list[str]:
    """The texts of the journal's entries, or of those of a kind."""
    return [str(entry.get("text", "")) for entry in entries() if kind in ("", entry["kind"])]


def until_said(*texts: str, deadline: float = DEADLINE) -> None:
    """Wait until each of them is in the journal."""

    def is_said() -> bool:
        lines = said()
        return all(any(text in line for line in lines) for text in texts)

    wait_until(is_said, str(texts), deadline)
