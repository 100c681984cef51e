"""The files of a bag, and helpful errors for paths that are no bag."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from archo_tui.errors import ArchoError
from archo_tui.regular_files import open_regular
from archo_tui.replay.linear_reader import MAGIC

_SUFFIX = ".mcap"
_EMPTY = "it is empty: nothing was recorded in it"
_SQLITE = "an SQLite bag: `ros2 bag convert` makes an MCAP of it"
_ZSTD = "compressed as a whole: unpack it (zstd -d FILE) and give what comes out"
_ROS1 = "a ROS 1 bag: `rosbags-convert` makes a ROS 2 bag of it"
_NO_BAG = "not a bag: give a .mcap file, or a folder with some"
# Advice by the suffix and by the first bytes of a file.
_OTHER_SUFFIXES = {".db3": _SQLITE, ".mcap.zstd": _ZSTD, ".db3.zstd": _ZSTD, ".bag": _ROS1}
_OTHER_MAGIC = {b"SQLite format 3": _SQLITE, b"\x28\xb5\x2f\xfd": _ZSTD, b"#ROSBAG": _ROS1}


def mcap_files(path: Path) -> list[Path]:
    """Return the .mcap files of a folder, sorted by name, or the path itself if it is no folder.

    Hidden files are left out. A path that is no folder is not looked at.

    Raises:
        ArchoError: The folder has no .mcap file or cannot be read; the message says what it holds.
    """
    try:
        if not path.is_dir():
            return [path]
        names = sorted(os.listdir(path))
    except OSError as error:
        raise _error(path, _reason(error)) from None
    found = [path / name for name in names if name.endswith(_SUFFIX) and name[0] != "."]
    if found:
        return found
    for suffix, advice in _OTHER_SUFFIXES.items():
        if any(name.endswith(suffix) for name in names):
            raise _error(path, advice)
    raise _error(path, "no .mcap file is in it: give the folder of a bag")


@contextmanager
def opened(path: Path) -> Iterator[BinaryIO]:
    """Open an MCAP file for a `with` block; its position is behind the first bytes, so seek first.

    Raises:
        ArchoError: The file cannot be opened or is no MCAP file; the message says why, and for a
            bag of another format how to convert it.
    """
    try:
        descriptor = open_regular(path, os.O_RDONLY)
    except FileNotFoundError:
        raise _error(path, "was not found: give the folder of a bag, or a .mcap file") from None
    except (OSError, ValueError) as error:
        raise _error(path, _reason(error)) from None
    with open(descriptor, "rb") as file:
        try:
            begin = file.read(16)
        except OSError as error:
            raise _error(path, _reason(error)) from None
        _check_magic(path, begin)
        yield file


def foreign_system_error(path: Path, profile: str, encoding: str) -> ArchoError:
    """Return the error for a file whose messages are not encoded as ROS 2's are.

    Args:
        path: The file.
        profile: The profile in its header; `ros1` gets the advice to convert the bag.
        encoding: The encoding of its messages.
    """
    if profile == "ros1":
        return _error(path, _ROS1)
    reason = f"not of ROS 2: its messages are encoded as {encoding or 'nothing known'}"
    return _error(path, f"{reason}, those of a ROS 2 bag as cdr")


def _check_magic(path: Path, begin: bytes) -> None:
    if begin.startswith(MAGIC):
        return
    if not begin:
        raise _error(path, _EMPTY)
    for magic, advice in _OTHER_MAGIC.items():
        if begin.startswith(magic):
            raise _error(path, advice)
    if begin[:5] == MAGIC[:5] and begin[6:8] == MAGIC[6:]:
        raise _error(path, "MCAP of another version: `mcap recover` may read it")
    if MAGIC.startswith(begin):
        raise _error(path, "cut off in its first bytes: nothing of it can be read")
    raise _error(path, _NO_BAG)


def _reason(error: OSError | ValueError) -> str:
    return getattr(error, "strerror", None) or str(error)


def _error(path: Path, why: str) -> ArchoError:
    return ArchoError(f"{path}: {why}")
