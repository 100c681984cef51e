"""The standard streams during the screen: what others print leaves the picture whole.

ROS's C libraries write to file descriptor 2, and the children of a node to 1 and 2.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

from archo_tui.base.paths import make_folder, state_file
from archo_tui.base.regular_files import open_regular

_GUARDS_OUTPUT = sys.platform != "win32"  # There Textual draws on it.
_MAX_SIZE = 1_000_000  # Bytes of what earlier screens have left.
PrintLine = Callable[[str], object]


def log_file() -> Path:
    """Return the path of the file for standard error, `archo-tui/stderr.log`."""
    return state_file("stderr.log")


@contextlib.contextmanager
def guarded_streams(path: Path, print_line: PrintLine | None = None) -> Iterator[None]:
    """Redirect the file descriptors 1 and 2 to the end of a file during the block.

    A file over 1 MB is emptied before; if it cannot be written, what is printed is lost.
    `sys.__stdout__` and `sys.__stderr__`, which Textual measures and draws on, are copies of the
    old descriptors. `print_line` is called on a thread with each line of descriptor 1, which does
    not go to the file then.
    """
    try:
        make_folder(path)
        target = open_regular(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        if os.fstat(target).st_size > _MAX_SIZE:
            os.ftruncate(target, 0)
    except OSError:
        target = os.open(os.devnull, os.O_WRONLY)
    real_out, real_err = os.dup(1), os.dup(2)
    before = sys.__stdout__, sys.__stderr__
    measured, drawn_on = (os.fdopen(os.dup(each), "w") for each in (real_out, real_err))
    try:
        if _GUARDS_OUTPUT:
            sys.__stdout__ = measured  # type: ignore[misc]
            _redirect_output(target, print_line)
        sys.__stderr__ = drawn_on  # type: ignore[misc]
        os.dup2(target, 2)
        yield
    finally:
        sys.__stdout__, sys.__stderr__ = before  # type: ignore[misc]
        for copy, descriptor in ((real_out, 1), (real_err, 2)):
            os.dup2(copy, descriptor)
            os.close(copy)
        measured.close()
        with contextlib.suppress(OSError):  # A terminal that does not read, or is gone.
            drawn_on.close()
        os.close(target)


def _redirect_output(target: int, print_line: PrintLine | None) -> None:
    """Let descriptor 1 be `target`, or a pipe whose lines a thread prints until its end."""
    if print_line is None:
        os.dup2(target, 1)
        return
    reader, writer = os.pipe()
    os.dup2(writer, 1)
    os.close(writer)

    def read() -> None:
        with open(reader, errors="replace") as lines:
            for line in lines:
                print_line(line)

    threading.Thread(target=read, name="output of children", daemon=True).start()
