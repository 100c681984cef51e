"""What a console leaves to other processes: its record at a restart, its STOP in a replay."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import tempfile
from collections.abc import Sequence
from typing import Any, NamedTuple

_VARIABLE = "ARCHO_TUI_HANDOVER"  # Names the file with the record.
# Names the descriptor of the socket to the console in whose terminal a replay runs.
CONSOLE_SOCKET = "ARCHO_TUI_CONSOLE_SOCKET"
STOP_KEY = "ARCHO_TUI_STOP_KEY"  # That console's, whatever the keymap's file says since then.
READY, GO, STOP = b"r", b"g", b"s"  # It could draw; it may; STOP's key was pressed.


class Handover(NamedTuple):
    """The record for the next process. All of it is plain JSON."""

    why: str = ""  # Of the restart.
    stop: bool = False  # A STOP was read that the robot has not been released from.
    stop_key: str = ""  # Textual's name.
    # Of the queue: id, title, action, type, and values by path.
    goals: Sequence[Sequence[Any]] = ()
    edits: Sequence[Sequence[Any]] = ()  # To be undone: node, values before, values after.
    lost: Sequence[str] = ()  # Lines about what is not taken along.
    listening: Sequence[Any] | None = None  # The socket's descriptor and path.
    terminal: Sequence[Any] | None = None  # Its `termios` settings from before the first start.


def restore_terminal(settings: Sequence[Any] | None) -> None:
    """Give the terminal its `termios` settings from before the first start; None: leave it."""
    if sys.platform != "win32" and settings is not None:
        import termios

        with contextlib.suppress(termios.error):
            termios.tcsetattr(0, termios.TCSANOW, [*settings])


def give(handover: Handover) -> None:
    """Write a record to a file that only this user can read, for the process that `exec` starts."""
    descriptor, path = tempfile.mkstemp(prefix="archo-tui-")
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        json.dump(handover._asdict(), file)
    os.environ[_VARIABLE] = path


def take() -> Handover | None:
    """Return the record that the process before has left, and remove it; None if there is none."""
    path = os.environ.pop(_VARIABLE, "")
    if not path:
        return None
    with contextlib.suppress(OSError, ValueError, TypeError):
        with open(path, encoding="utf-8") as file:
            left = Handover(**json.load(file))
        os.unlink(path)
        return left
    return None
