"""The check that a screen can be shown where the program runs."""

from __future__ import annotations

import os
import sys

from archo_tui.errors import ArchoError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TextIO

# Variables for Textual's developers, which press keys or end the app, and a size that may not be
# the terminal's. A shell exports them to every program.
_FOREIGN = ("TEXTUAL_DRIVER", "TEXTUAL_PRESS", "TEXTUAL_SCREENSHOT", "COLUMNS", "LINES")


def require_terminal(stdin: TextIO | None) -> None:
    """Unset variables that would disturb a screen; raise ArchoError unless one can be shown.

    Call it before Textual is imported, which reads these environment variables once.
    """
    for name in _FOREIGN:
        os.environ.pop(name, None)
    term = os.environ.get("TERM", "")
    if term in ("", "dumb", "unknown"):
        term_text = f"TERM is {term}" if term else "TERM is not set"
        raise ArchoError(f"{term_text}: this terminal cannot show a screen, use --plain")
    streams = {"stdin": stdin, "stdout": sys.stdout}
    if sys.platform != "win32":  # Textual's driver for POSIX draws on standard error.
        streams["stderr"] = sys.__stderr__
    for name, stream in streams.items():
        if stream is None or not stream.isatty():  # None if it is closed.
            raise ArchoError(f"{name} is not a terminal: run archo-tui in one, or use --plain")
        if _device(stream) != _device(stdin or stream):
            raise ArchoError(f"{name} is another terminal than stdin: run archo-tui in one of them")


def _device(stream: TextIO) -> int:
    """Return a terminal's device number, as a container may not know its name; 0 on Windows."""
    if sys.platform == "win32":
        return 0
    return os.fstat(stream.fileno()).st_rdev
