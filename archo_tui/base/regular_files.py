"""Opening of files at known places: regular ones only, of a bounded size, without waiting.

A pipe that nobody fills would block for ever, and a device may have no end.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

MAX_BYTES = 1_000_000  # Of a file that is read.


def open_regular(path: Path, flags: int) -> int:
    """Return the descriptor, for the caller to close, of a file opened without waiting.

    A new file is readable by its owner only. OSError also for what is no regular file; ValueError
    for a NUL character in the path.
    """
    # O_NONBLOCK has no effect on regular files, and keeps a pipe from blocking.
    flags |= getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
    try:
        descriptor = os.open(path, flags, 0o600)
    except OSError as error:
        if error.errno != errno.ENXIO:  # A pipe without a reader, or a socket.
            raise
        raise _not_regular(path) from None
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise _not_regular(path)
    return descriptor


def read(path: Path) -> bytes:
    """Return the content of a file; OSError also if it is larger than MAX_BYTES, or not regular.

    ValueError for a NUL character in the path.
    """
    with open(open_regular(path, os.O_RDONLY), "rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise OSError(errno.EFBIG, f"larger than {MAX_BYTES // 1_000_000} MB", str(path))
    return data


def replace(path: Path, text: str) -> None:
    """Replace a file, or make it, so that a reader finds the old text or the new one.

    OSError if that fails; the old text stays.
    """
    new = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        new.write_text(text, encoding="utf-8")
        new.replace(path)
    except OSError:
        new.unlink(missing_ok=True)  # A full disk leaves half of the text.
        raise


def _not_regular(path: Path) -> OSError:
    return OSError(errno.EINVAL, "not a regular file", str(path))
