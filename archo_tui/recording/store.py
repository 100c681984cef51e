"""The folder of recordings: each appears when it is complete, and all share a budget of bytes."""

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

WARN_AT = 0.9  # The share of the budget at which the operator is warned.
MIN_FREE = 100_000_000  # Bytes that recordings always leave free on the disk.
_HIDDEN_PREFIX = "."  # Of the name of a recording while it is being written.
_MAX_WORD = 60  # Characters of the reason in a recording's name.
_TRIAL_BYTES = 100_000  # Written to see if the disk takes data again.
_STALE_SECONDS = 3600.0  # Age at which a hidden folder is taken for a leftover.


class Recording(NamedTuple):
    """A complete recording on the disk.

    Attributes:
        folder: Its folder, whose name is the recording's.
        start: Unix time of its first message, in s.
        seconds: The time from its first to its last message.
        messages: Their number.
        why: What triggered it, joined by commas in the order of events; "" if another tool wrote
            it.
        kept: True if it was recorded by hand: it is not deleted for room.
        bytes: Its size on the disk.
        number: Its place in the order of writing; 0 if another tool wrote it.
    """

    folder: Path
    start: float
    seconds: float
    messages: int
    why: str
    kept: bool
    bytes: int
    number: int = 0

    @property
    def name(self) -> str:
        """Return the name of its folder, which `archo-tui recordings --delete` takes."""
        return self.folder.name


def list_recordings(folder: Path) -> list[Recording]:
    """Return the recordings of a folder, the oldest first; what cannot be read is left out.

    They are sorted by their number before their date: a computer whose clock was set back, or that
    has none, gives a new recording an old date.

    Raises:
        OSError: The folder cannot be read; a missing one counts as empty.
    """
    found = []
    with suppress(FileNotFoundError):
        for path in folder.iterdir():
            ours = path.is_dir() and not path.is_symlink()
            if ours and not path.name.startswith(_HIDDEN_PREFIX):
                with suppress(OSError, ValueError):
                    found.append(_read_recording(path))
    return sorted(found, key=lambda recording: (recording.number, recording.start, recording.name))


def _read_recording(path: Path) -> Recording:
    info = bag.read_info(path)
    size = sum(file.lstat().st_size for file in path.iterdir())
    why, kept = info.why, info.kept
    return Recording(path, info.start, info.seconds, info.messages, why, kept, size, info.number)


def delete(recording: Recording) -> None:
    """Delete the folder of a recording with all that is in it.

    Raises:
        OSError: The disk refuses it, or the folder is gone already.
    """
    shutil.rmtree(recording.folder)


def next_number(folder: Path) -> int:
    """Return the number for a recording that is written now: one above the highest in the folder.

    Raises:
        OSError: The folder cannot be read.
    """
    return 1 + max((recording.number for recording in list_recordings(folder)), default=0)


def check_free(folder: Path) -> None:
    """Raise OSError if the disk of a folder has less than MIN_FREE bytes left."""
    if shutil.disk_usage(folder).free < MIN_FREE:
        raise OSError(errno.ENOSPC, f"less than {MIN_FREE / 1e6:.0f} MB are free", str(folder))


def make_folder(wanted: Path) -> Path:
    """Make a folder for a bag that grows on the disk, and return its path.

    Args:
        wanted: Its path, in a folder that exists; if it is taken, a number is put behind its name.

    Raises:
        OSError: The disk is almost full or refuses it.
    """
    check_free(wanted.parent)
    for number in itertools.count(1):
        made = wanted if number == 1 else wanted.with_name(f"{wanted.name}_{number}")
        with suppress(FileExistsError):
            made.mkdir(mode=0o700)
            break
    return made


def add(folder: Path, at: float, what: str, fill: Callable[[Path], None]) -> Path:
    """Write a recording that appears under its name only when all of it is on the disk.

    If `fill` raises an exception, nothing is left of the recording, and the exception passes on.

    Args:
        folder: The folder of recordings; made if it is missing.
        at: Unix time, for the name.
        what: What happened, for the name.
        fill: Called with the folder into which it writes the bag.

    Returns:
        The recording's folder, with a number behind its name if the name was taken.

    Raises:
        OSError: The disk is almost full or refuses it.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    check_free(folder)
    word = re.sub(r"\W+", "_", what, flags=re.ASCII).strip("_")[:_MAX_WORD]
    return _write_hidden(folder / f"{datetime.fromtimestamp(at):%Y-%m-%d_%H-%M-%S}_{word}", fill)


def _write_hidden(wanted: Path, fill: Callable[[Path], None]) -> Path:
    """Fill a hidden folder, put it on the disk, and rename it to `wanted` or the next free name.

    Return the final path. If anything fails, the folder is deleted.
    """
    made = wanted.with_name(f"{_HIDDEN_PREFIX}{wanted.name}.{os.getpid()}")
    made.mkdir(mode=0o700)
    try:
        fill(made)
        for file in made.iterdir():
            file.chmod(0o600)
            _sync(file)
        _sync(made)
        whole = _rename_to_free(made, wanted)
    except BaseException:
        shutil.rmtree(made, ignore_errors=True)
        raise
    _sync(wanted.parent)
    return whole


def _rename_to_free(made: Path, wanted: Path) -> Path:
    """Rename a folder to `wanted` or, if that is taken, with a number behind; return the path.

    Raises:
        OSError: The folder cannot be renamed.
    """
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


def check_writable(folder: Path) -> None:
    """Raise OSError if the folder cannot take a small file, or the disk is almost full.

    Make the folder if it is missing.
    """
    made = folder / f"{_HIDDEN_PREFIX}try.{os.getpid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    check_free(folder)
    try:
        made.write_bytes(bytes(_TRIAL_BYTES))
        _sync(made)
    finally:
        made.unlink(missing_ok=True)


def make_room(
    folder: Path, budget: int, written: Path | None = None
) -> tuple[int, list[Recording]]:
    """Delete the oldest recordings until the rest is within the budget.

    Recordings kept by hand, and the newest, are not deleted, so that the rest may exceed the
    budget. What a killed process has left, in hidden folders, is deleted once it is an hour old.

    Args:
        folder: The folder of recordings.
        budget: The bytes that all of them may take together.
        written: The recording written just now, which is not deleted either.

    Returns:
        The bytes that remain, and the deleted recordings.

    Raises:
        OSError: The disk refuses it.
    """
    for path in folder.iterdir():
        with suppress(FileNotFoundError):  # Another console may have renamed it meanwhile.
            if (
                path.name.startswith(_HIDDEN_PREFIX)
                and time.time() - path.stat().st_mtime > _STALE_SECONDS
            ):
                shutil.rmtree(path, ignore_errors=True)
    known = list_recordings(folder)
    size = sum(recording.bytes for recording in known)
    gone = []
    for recording in known[:-1]:
        if size <= budget:
            break
        if not (recording.kept or recording.folder == written):
            with suppress(FileNotFoundError):  # Another console may have deleted it meanwhile.
                delete(recording)
            size -= recording.bytes
            gone.append(recording)
    return size, gone
