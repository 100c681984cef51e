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
    """Return the descriptor of a file, opened as by `os.open` without waiting.

    The caller closes it. A new file is readable by its owner only.

    Args:
        path: The file.
        flags: The flags of `os.open`.

    Raises:
        OSError: It cannot be opened, or is no regular file.
        ValueError: The path holds a NUL character.
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
    """Return the content of a file.

    Raises:
        OSError: It cannot be read, is no regular file, or larger than MAX_BYTES.
        ValueError: The path holds a NUL character.
    """
    with open(open_regular(path, os.O_RDONLY), "rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise OSError(errno.EFBIG, f"larger than {MAX_BYTES // 1_000_000} MB", str(path))
    return data


def replace(path: Path, text: str) -> None:
    """Replace a file, or make it, so that a reader finds the old text or the new one.

    If that fails, the old text stays.

    Args:
        path: The file, whose folder exists.
        text: The new text, which is written as UTF-8.

    Raises:
        OSError: The disk refuses it.
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
