"""What hosted nodes print: lines of the events instead of letters on the screen.

What reaches a stream all the same has nothing in it that a terminal acts on.
"""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TextIO

from archo_tui.robot.text import safe

_PERIOD = 1.0  # s in which each node may say so many lines:
_MOST = 50
_LONGEST = 10_000  # characters of a line


@dataclass
class _Said:
    """What one node has printed of late."""

    rest: str = ""  # the line that is not ended
    since: float = field(default_factory=time.monotonic)
    lines: int = 0
    left_out: int = 0


class _Output(io.TextIOBase):
    """Stands before a stream, and is what that is but for what is written."""

    def __init__(self, other: TextIO) -> None:
        self._other = other

    def flush(self) -> None:
        self._other.flush()

    def close(self) -> None:
        """Nothing is held back; the other is not ours, and may be closed when this one is freed."""

    def isatty(self) -> bool:
        return self._other.isatty()

    def fileno(self) -> int:
        return self._other.fileno()


class HarmlessOutput(_Output):
    """Standard error, for whoever prints there: a node, a thread of its own, Python's warnings."""

    def write(self, text: str) -> int:
        self._other.write("\n".join(safe(line.expandtabs()) for line in text.split("\n")))
        return len(text)


class NodeOutput(_Output):
    """A standard output that tells threads apart: those of nodes have names that begin with `/`.

    The others are threads that nodes have started; the console prints in the main thread only.
    """

    def __init__(self, other: TextIO, note: Callable[[str, str, str], None]) -> None:
        """`note(level, source, text)` takes a line; what the main thread prints goes to `other`."""
        super().__init__(other)
        self._note = note
        self._lock = threading.Lock()
        self._said: dict[str, _Said] = {}

    def write(self, text: str) -> int:
        thread = threading.current_thread()
        if thread is threading.main_thread():
            return self._other.write(text)
        name = thread.name
        with self._lock:
            lines = self._lines(name, text)
        for line in lines:
            self._note("INFO", f"{name.lstrip('/')} stdout", line)
        return len(text)

    def _lines(self, name: str, text: str) -> list[str]:
        """The whole lines that are to be shown; of a storm only so many, and how many more."""
        said = self._said.setdefault(name, _Said())
        *lines, said.rest = (said.rest + text).split("\n")
        if len(said.rest) > _LONGEST:
            lines, said.rest = [*lines, said.rest], ""
        shown: list[str] = []
        now = time.monotonic()
        if lines and now - said.since > _PERIOD:
            if said.left_out:
                shown.append(f"({said.left_out} lines were left out)")
            said.since, said.lines, said.left_out = now, 0, 0
        room = max(_MOST - said.lines, 0)
        said.lines += len(lines[:room])
        said.left_out += len(lines[room:])
        return [*shown, *(line[:_LONGEST] for line in lines[:room])]
