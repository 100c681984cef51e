"""The folder of recordings: each whole or not there, and all together within a budget."""

from __future__ import annotations

import errno
import itertools
import os
import re
import shutil
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from archo_tui.recording import bag

ALARM_AT = 0.9  # of the budget
FLOOR = 100_000_000  # bytes that are left free on the disk, whatever happens
_UNFINISHED = "."  # how the names of those begin that are being written
_LONGEST = 60  # characters of what happened, in a name
_TRIED = 100_000  # bytes that a disk must have room for, before the trouble is over
_STALE = 3600.0  # s after which one is nobody's any more


class Recording(NamedTuple):
    """One that is whole."""

    folder: Path
    start: float  # Unix time of its first message
    seconds: float
    messages: int
    why: str  # what happened, in the order in which it did
    kept: bool  # by hand: it does not go when room is needed
    bytes: int
    number: int = 0  # in the order in which they were written; 0: another tool has written it

    @property
    def name(self) -> str:
        """What `recordings --delete` calls it."""
        return self.folder.name


def listed(folder: Path) -> list[Recording]:
    """List all recordings, the oldest first; what is none is left out. Raises OSError.

    The order is that of writing: a computer whose clock was set back, or that has none, gives a
    new recording an old date.
    """
    found = []
    with suppress(FileNotFoundError):
        for path in folder.iterdir():
            ours = path.is_dir() and not path.is_symlink()
            if ours and not path.name.startswith(_UNFINISHED):
                with suppress(OSError, ValueError):
                    found.append(_read(path))
    return sorted(found, key=lambda one: (one.number, one.start, one.name))


def _read(path: Path) -> Recording:
    said = bag.about(path)
    size = sum(file.lstat().st_size for file in path.iterdir())
    return Recording(path, *said[:5], size, said.number)


def delete(recording: Recording) -> None:
    """Raises OSError."""
    shutil.rmtree(recording.folder)


def next_number(folder: Path) -> int:
    """Return the number of a recording that is written now. Raises OSError."""
    return 1 + max((one.number for one in listed(folder)), default=0)


def check_free(folder: Path) -> None:
    """Raise OSError while so little is free that the rest of the system needs it."""
    if shutil.disk_usage(folder).free < FLOOR:
        raise OSError(errno.ENOSPC, f"less than {FLOOR / 1e6:.0f} MB are free", str(folder))


def begin(wanted: Path) -> Path:
    """Make the folder of that name, or with a number behind it. Raises OSError.

    It is for a bag that is written piece by piece, and seen from the first one on.
    """
    check_free(wanted.parent)
    for number in itertools.count(1):
        made = wanted if number == 1 else wanted.with_name(f"{wanted.name}_{number}")
        with suppress(FileExistsError):
            made.mkdir(mode=0o700)
            break
    return made


def add(folder: Path, at: float, what: str, fill: Callable[[Path], None]) -> Path:
    """A new recording of that time and name, which `fill(folder)` writes. Raises OSError.

    It appears under its name when all of it is on the disk.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    check_free(folder)
    word = re.sub(r"\W+", "_", what, flags=re.ASCII).strip("_")[:_LONGEST]
    return _write(folder / f"{datetime.fromtimestamp(at):%Y-%m-%d_%H-%M-%S}_{word}", fill)


def _write(wanted: Path, fill: Callable[[Path], None]) -> Path:
    """A bag of that name, or with a number behind it where there is one. Raises OSError."""
    made = wanted.with_name(f"{_UNFINISHED}{wanted.name}.{os.getpid()}")
    made.mkdir(mode=0o700)
    try:
        fill(made)
        for file in made.iterdir():
            file.chmod(0o600)
            _sync(file)
        _sync(made)
        whole = _rename(made, wanted)
    except BaseException:
        shutil.rmtree(made, ignore_errors=True)
        raise
    _sync(wanted.parent)
    return whole


def _rename(made: Path, wanted: Path) -> Path:
    """To that name, or with a number behind it: two may happen within a second."""
    number, whole = 1, wanted
    while True:
        try:
            return made.rename(whole)
        except OSError as error:
            if error.errno not in (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR):
                raise
        number += 1
        whole = wanted.with_name(f"{wanted.name}_{number}")


def _sync(path: Path) -> None:
    if os.name == "nt" and path.is_dir():
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def try_out(folder: Path) -> None:
    """Raises OSError while nothing can be written."""
    made = folder / f"{_UNFINISHED}try.{os.getpid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    check_free(folder)
    try:
        made.write_bytes(bytes(_TRIED))
        _sync(made)
    finally:
        made.unlink(missing_ok=True)


def make_room(
    folder: Path, budget: int, written: Path | None = None
) -> tuple[int, list[Recording]]:
    """Delete the oldest that nobody kept until the rest is within the budget. Raises OSError.

    Args:
        folder: Where the recordings are.
        budget: Bytes that all of them may take together.
        written: The one that was written just now, which stays, as the newest does.

    Returns:
        The bytes that are left, and what went. Leftovers of a process that was killed go too.
    """
    for path in folder.iterdir():
        with suppress(FileNotFoundError):  # another console has finished it
            if path.name.startswith(_UNFINISHED) and time.time() - path.stat().st_mtime > _STALE:
                shutil.rmtree(path, ignore_errors=True)
    known = listed(folder)
    size = sum(one.bytes for one in known)
    gone = []
    for one in known[:-1]:
        if size <= budget:
            break
        if not (one.kept or one.folder == written):
            with suppress(FileNotFoundError):  # another console has done it
                delete(one)
            size -= one.bytes
            gone.append(one)
    return size, gone
