"""The files of a bag; and for what is no bag, one line that says what it is and what to do."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from archo_tui.errors import ArchoError
from archo_tui.regular_files import open_regular
from archo_tui.replay.walk import MAGIC

_SUFFIX = ".mcap"
_EMPTY = "it is empty: nothing was recorded in it"
_SQLITE = "an SQLite bag: `ros2 bag convert` makes an MCAP of it"
_ZSTD = "compressed as a whole: unpack it (zstd -d FILE) and give what comes out"
_ROS1 = "a ROS 1 bag: `rosbags-convert` makes a ROS 2 bag of it"
_NONE = "not a bag: give a .mcap file, or a folder with some"
# by how their names end, and how they begin
_OTHERS = {".db3": _SQLITE, ".mcap.zstd": _ZSTD, ".db3.zstd": _ZSTD, ".bag": _ROS1}
_BEGINS = {b"SQLite format 3": _SQLITE, b"\x28\xb5\x2f\xfd": _ZSTD, b"#ROSBAG": _ROS1}


def files(path: Path) -> list[Path]:
    """The .mcap files of a bag. Raises ArchoError."""
    try:
        if not path.is_dir():
            return [path]
        names = sorted(os.listdir(path))
    except OSError as error:
        raise _refused(path, _said(error)) from None
    found = [path / name for name in names if name.endswith(_SUFFIX) and name[0] != "."]
    if found:
        return found
    for end, said in _OTHERS.items():
        if any(name.endswith(end) for name in names):
            raise _refused(path, said)
    raise _refused(path, "no .mcap file is in it: give the folder of a bag")


@contextmanager
def opened(path: Path) -> Iterator[BinaryIO]:
    """The file, which begins as MCAP does. Raises ArchoError."""
    try:
        descriptor = open_regular(path, os.O_RDONLY)
    except FileNotFoundError:
        raise _refused(path, "was not found: give the folder of a bag, or a .mcap file") from None
    except (OSError, ValueError) as error:
        raise _refused(path, _said(error)) from None
    with open(descriptor, "rb") as file:
        try:
            begin = file.read(16)
        except OSError as error:
            raise _refused(path, _said(error)) from None
        _check(path, begin)
        yield file


def another_system(path: Path, profile: str, encoding: str) -> ArchoError:
    """For a file whose messages are not those of ROS 2."""
    if profile == "ros1":
        return _refused(path, _ROS1)
    said = f"not of ROS 2: its messages are encoded as {encoding or 'nothing known'}"
    return _refused(path, f"{said}, those of a ROS 2 bag as cdr")


def _check(path: Path, begin: bytes) -> None:
    if begin.startswith(MAGIC):
        return
    if not begin:
        raise _refused(path, _EMPTY)
    for first, said in _BEGINS.items():
        if begin.startswith(first):
            raise _refused(path, said)
    if begin[:5] == MAGIC[:5] and begin[6:8] == MAGIC[6:]:
        raise _refused(path, "MCAP of another version: `mcap recover` may read it")
    if MAGIC.startswith(begin):
        raise _refused(path, "cut off in its first bytes: nothing of it can be read")
    raise _refused(path, _NONE)


def _said(error: OSError | ValueError) -> str:
    return getattr(error, "strerror", None) or str(error)


def _refused(path: Path, why: str) -> ArchoError:
    return ArchoError(f"{path}: {why}")
