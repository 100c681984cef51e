"""Functions that print for the command line: complaints, and text without escape sequences."""

from __future__ import annotations

import errno
import os
import sys
from io import TextIOBase

from archo_tui.safe_text import safe

FAILED, MISUSED = 1, 2  # Exit codes.


def complain(text: str) -> None:
    """Print a line on standard error, if that is open, as `archo-tui: ...`."""
    if sys.stderr is not None:
        print(f"archo-tui: {safe(text)}", file=sys.stderr)


class ClosedOutput(TextIOBase):
    """A stand-in for a closed standard output: each write raises OSError."""

    def write(self, text: str) -> int:
        raise OSError(errno.EBADF, os.strerror(errno.EBADF))


def report_lost_output() -> None:
    """Have printing to a closed standard output raise OSError instead of losing text."""
    if sys.stdout is None:
        sys.stdout = ClosedOutput()
