"""Functions that print for the command line: complaints, and text without escape sequences."""

from __future__ import annotations

import errno
import os
import sys
from io import TextIOBase

FAILED, MISUSED = 1, 2  # Exit codes.


def complain(text: str) -> None:
    """Print a line on standard error, if that is open."""
    if sys.stderr is not None:
        print(f"archo-tui: {safe_line(text)}", file=sys.stderr)


def safe_line(text: str) -> str:
    """Return one line on which no terminal acts."""
    if text.isascii() and text.isprintable():
        return text
    # It imports Rich, which takes most of the time of a short command.
    from archo_tui.robot.text import safe

    return safe(text)


class ClosedOutput(TextIOBase):
    """A stand-in for a closed standard output, in which Python would lose what is printed."""

    def write(self, text: str) -> int:
        raise OSError(errno.EBADF, os.strerror(errno.EBADF))


def report_lost_output() -> None:
    """Make it an error from here on to print to a closed standard output."""
    if sys.stdout is None:
        sys.stdout = ClosedOutput()
