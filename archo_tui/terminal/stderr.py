"""Standard error during the screen: what libraries print goes to a file instead of the picture.

ROS's C libraries write to file descriptor 2.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from archo_tui.paths import make_folder, state_file
from archo_tui.regular_files import open_regular


def log_file() -> Path:
    """Return the path of the file for standard error, `archo-tui/stderr.log`."""
    return state_file("stderr.log")


@contextlib.contextmanager
def guarded_stderr(path: Path) -> Iterator[None]:
    """Redirect file descriptor 2 to a file during the block, and restore it at the end.

    The old content of the file is deleted; its folder is made if it is missing. `sys.__stderr__`,
    on which Textual draws, is a copy of the old descriptor meanwhile. If the file cannot be
    written, what is printed is lost: a clean screen matters more.
    """
    try:
        make_folder(path)
        target = open_regular(path, os.O_WRONLY | os.O_CREAT)
        os.ftruncate(target, 0)
    except OSError:
        target = os.open(os.devnull, os.O_WRONLY)
    real = os.dup(2)
    before = sys.__stderr__
    try:
        os.dup2(target, 2)
        sys.__stderr__ = os.fdopen(os.dup(real), "w")  # type: ignore[misc]  # Textual draws here
        yield
    finally:
        os.dup2(real, 2)
        sys.__stderr__ = before  # type: ignore[misc]
        os.close(real)
        os.close(target)
