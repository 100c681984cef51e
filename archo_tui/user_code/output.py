"""The output of hosted nodes, which becomes events instead of letters across the screen.

Text that reaches a stream all the same contains nothing that a terminal acts on.
"""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TextIO

from archo_tui.base.safe_text import safe

_PERIOD = 1.0  # Seconds in which each node may print _MAX_LINES lines.
_MAX_LINES = 50
MAX_LENGTH = 10_000  # Characters of a line.
_OWNER = "owner of output"  # Of a thread's attributes.


def share_output(thread: threading.Thread, owner: threading.Thread) -> None:
    """Let the lines that a thread prints count as those of its owner, by name and limit."""
    vars(thread)[_OWNER] = owner


def _owner_name() -> str:
    """Return the name of the present thread's owner, or its own."""
    thread = threading.current_thread()
    name: str = vars(thread).get(_OWNER, thread).name
    return name


@dataclass
class _Printed:
    """The output of the threads of one name within the current period."""

    rest: str = ""  # The line without its end yet.
    since: float = field(default_factory=time.monotonic)
    lines: int = 0  # That were shown.
    left_out: int = 0


class _Output(io.TextIOBase):
    """The base of a stream that stands in front of another one; a subclass defines `write`."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def flush(self) -> None:
        self._stream.flush()

    def close(self) -> None:
        """Do nothing: the other stream is not ours, and nothing is held back."""

    def isatty(self) -> bool:
        return self._stream.isatty()

    def fileno(self) -> int:
        return self._stream.fileno()


class HarmlessOutput(_Output):
    """A standard error that makes control characters visible, for all threads."""

    def write(self, text: str) -> int:
        """Write text with control characters made visible and tabs expanded; line ends are kept."""
        self._stream.write("\n".join(safe(line.expandtabs()) for line in text.split("\n")))
        return len(text)


class NodeOutput(_Output):
    """A standard output that turns lines of other threads than the main one into events.

    The console itself prints in the main thread only. The source of an event is `NAME stdout` by
    the name of the thread, or of its owner: that of its node.
    """

    def __init__(self, stream: TextIO, note: Callable[[str, str, str], None]) -> None:
        super().__init__(stream)
        self._note = note
        self._lock = threading.Lock()
        self._printed: dict[str, _Printed] = {}  # By the name of the thread.

    def write(self, text: str) -> int:
        """Write text of the main thread; note each whole line of another thread, on that thread."""
        if threading.current_thread() is threading.main_thread():
            return self._stream.write(text)
        name = _owner_name()
        with self._lock:
            lines = self._lines(name, text)
        for line in lines:
            self._note("INFO", f"{name.lstrip('/')} stdout", line)
        return len(text)

    def end_line(self) -> None:
        """End the line that the calling thread's program has begun, if any."""
        name = _owner_name()
        if name in self._printed and self._printed[name].rest:
            self.write("\n")

    def _lines(self, name: str, text: str) -> list[str]:
        """Add text of a thread, and return the complete lines to show, cut to MAX_LENGTH.

        Of a flood, _MAX_LINES in a period are shown; the first output after the period tells how
        many were left out. Text without a line end is a line once it is longer than MAX_LENGTH.
        """
        printed = self._printed.setdefault(name, _Printed())
        *lines, printed.rest = (printed.rest + text).split("\n")
        if len(printed.rest) > MAX_LENGTH:
            lines, printed.rest = [*lines, printed.rest], ""
        shown: list[str] = []
        now = time.monotonic()
        if lines and now - printed.since > _PERIOD:
            if printed.left_out:
                shown.append(f"({printed.left_out} lines were left out)")
            printed.since, printed.lines, printed.left_out = now, 0, 0
        room = max(_MAX_LINES - printed.lines, 0)
        printed.lines += len(lines[:room])
        printed.left_out += len(lines[room:])
        return [*shown, *(line[:MAX_LENGTH] for line in lines[:room])]
