"""The folder of recordings: each appears when it is complete, and all share a budget of bytes."""

from __future__ import annotations

import errno
import itertools
import json
import os
import re
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from archo_tui.base.errors import ArchoError
from archo_tui.base.paths import state_file
from archo_tui.base.regular_files import read

METADATA = "metadata.yaml"
BUDGET = 1_000_000_000  # Bytes of all recordings together.
WARN_AT = 0.9  # The share of the budget at which the operator is warned.
MIN_FREE = 100_000_000  # Bytes that recordings always leave free on the disk.
KEPT = "kept"  # The reason of a recording that the operator asked for.
_HIDDEN_PREFIX = "."  # Of the name of a recording while it is being written.
_MAX_WORD = 60  # Characters of the reason in a recording's name.
_MAX_REASON = 1000  # Characters; another tool's bag may hold any text.
_MAX_COUNT = 2**63  # In ns since the epoch, an int64 of rosbag2: the year 2262.
_NANOSECONDS, _NUMBER = re.compile(r"[0-9]{1,19}"), re.compile(r"[0-9]{1,9}")
_STALE_SECONDS = 3600.0  # Age at which a hidden folder is taken for a leftover.


class Recording(NamedTuple):
    """A complete recording on the disk, as its `metadata.yaml` describes it."""

    folder: Path
    start: float  # Unix time of its first message, in s.
    seconds: float
    messages: int
    why: str  # What triggered it, joined by commas; "" if another tool wrote it.
    kept: bool  # By hand: it is not deleted for room.
    number: int = 0  # Its place in the order of writing; 0 if another tool wrote it.
    at: float | None = None  # Unix time of the first trigger, in s; None if that is not known.
    bytes: int = 0  # On the disk.

    @property
    def name(self) -> str:
        """The name of its folder, which `archo-tui recordings --delete` takes."""
        return self.folder.name


def read_recording(folder: Path) -> Recording:
    """Return what `metadata.yaml` says of a bag, but `bytes`; ValueError if it describes none."""
    try:
        bag = _read_metadata(folder)
        custom = bag.get("custom_data")
        ours = custom if isinstance(custom, dict) else {}
        why, number, at = ours.get("why"), str(ours.get("number")), str(ours.get("at"))
        return Recording(
            folder,
            _checked_count(bag["starting_time"]["nanoseconds_since_epoch"]) / 1e9,
            _checked_count(bag["duration"]["nanoseconds"]) / 1e9,
            _checked_count(bag["message_count"]),
            why[:_MAX_REASON] if isinstance(why, str) else "",
            ours.get("kept") == "yes",
            int(number) if _NUMBER.fullmatch(number) else 0,
            int(at) / 1e9 if _NANOSECONDS.fullmatch(at) else None,
        )
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ValueError(f"{folder.name}: {METADATA} does not describe a bag") from None


def _read_metadata(folder: Path) -> Any:
    import yaml

    try:
        return yaml.safe_load(read(folder / METADATA))["rosbag2_bagfile_information"]
    except (yaml.YAMLError, KeyError, TypeError, RecursionError) as error:
        raise ValueError(error) from None


def missing_parts(path: Path) -> list[str]:
    """Return the names of .mcap files that the `metadata.yaml` of a bag names and that are gone."""
    try:
        named = _read_metadata(path)["relative_file_paths"]
    except (OSError, ValueError, KeyError, TypeError):  # A single file, or its writer was killed.
        return []
    texts = filter(lambda name: isinstance(name, str), named if isinstance(named, list) else ())
    names = [os.path.basename(name).removesuffix(".zstd") for name in texts]
    # Unlike Path.exists, os.path.exists returns False for names that are too long.
    return [n for n in names if n.endswith(".mcap") and not os.path.exists(path / n)]


def _checked_count(value: Any) -> int:
    if not isinstance(value, int) or not 0 <= value < _MAX_COUNT:
        raise ValueError(value)
    return value


def list_recordings(folder: Path) -> list[Recording]:
    """Return the recordings of a folder by their numbers, since a clock may be set back."""
    found = []
    with suppress(FileNotFoundError):
        for path in folder.iterdir():
            ours = path.is_dir() and not path.is_symlink()
            if ours and not path.name.startswith(_HIDDEN_PREFIX):
                with suppress(OSError, ValueError):
                    size = sum(file.lstat().st_size for file in path.iterdir())
                    found.append(read_recording(path)._replace(bytes=size))
    return sorted(found, key=lambda recording: (recording.number, recording.start, recording.name))


def own_recordings() -> list[Recording]:
    """Return the recordings of this user, the newest first; raise ArchoError if that fails."""
    try:
        return list_recordings(state_file("recordings"))[::-1]
    except OSError as error:
        raise ArchoError(f"{error.filename}: {error.strerror}") from None


def delete(recording: Recording) -> None:
    """Delete the folder of a recording with all that is in it."""
    shutil.rmtree(recording.folder)


def delete_named(names: Sequence[str]) -> Iterator[str]:
    """Delete recordings, and yield a line for each; nothing is deleted if a name is unknown."""
    known = {recording.name: recording for recording in own_recordings()}
    for name in names:
        if name not in known:
            raise ArchoError(f"no recording is called {name} (see archo-tui recordings)")
    for name in dict.fromkeys(names):
        try:
            delete(known[name])
        except OSError as error:
            raise ArchoError(f"{error.filename or name}: {error.strerror or error}") from None
        yield f"deleted {name}"


def listing(*, as_json: bool) -> Iterator[str]:
    """Yield a line for each recording, the newest first, or one that says that there is none."""
    found = own_recordings()
    widest = max((len(recording.name) for recording in found), default=0)
    for recording in found:
        if as_json:
            start = datetime.fromtimestamp(recording.start).astimezone().isoformat()
            yield json.dumps(
                {
                    "name": recording.name,
                    "path": str(recording.folder),
                    "start": start,
                    "seconds": recording.seconds,
                    "why": recording.why,
                    "kept": recording.kept,
                    "messages": recording.messages,
                    "bytes": recording.bytes,
                }
            )
        else:
            yield f"{recording.name:<{widest}}  {length_size_and_why(recording)}"
    if not found and not as_json:
        yield f"no recordings in {state_file('recordings')}"


def length_size_and_why(recording: Recording) -> str:
    """Return a text such as `   65 s      212 kB  STOP, kept`, whose columns are aligned."""
    number, unit, digits = recording.bytes / 1e3, "kB", 0
    if recording.bytes >= 1e6:
        number, unit, digits = recording.bytes / 1e6, "MB", 1
    is_kept = recording.kept and KEPT not in recording.why.split(", ")
    why = f"{recording.why}{', kept' if is_kept else ''}"
    return f"{recording.seconds:5.0f} s  {number:7.{digits}f} {unit}  {why}"


def next_number(folder: Path) -> int:
    """Return the number for the next recording: one above the highest in the folder."""
    return 1 + max((recording.number for recording in list_recordings(folder)), default=0)


def check_free(folder: Path) -> None:
    """Raise OSError if the disk of a folder has less than MIN_FREE bytes left."""
    if shutil.disk_usage(folder).free < MIN_FREE:
        raise OSError(errno.ENOSPC, f"less than {MIN_FREE / 1e6:.0f} MB are free", str(folder))


def _with_free_name(wanted: Path, make: Callable[[Path], object]) -> Path:
    for number in itertools.count(1):
        path = wanted if number == 1 else wanted.with_name(f"{wanted.name}_{number}")
        try:
            make(path)
            break
        except OSError:
            if not os.path.lexists(path):
                raise
    return path


def make_folder(wanted: Path) -> Path:
    """Make the folder of a bag that grows on the disk, maybe with a number behind its name."""
    check_free(wanted.parent)
    return _with_free_name(wanted, partial(Path.mkdir, mode=0o700))


def make_hidden(folder: Path) -> Path:
    """Make a folder for a recording that is to appear by `publish` when it is complete."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    check_free(folder)
    hidden = folder / f"{_HIDDEN_PREFIX}new.{os.getpid()}"
    return _with_free_name(hidden, partial(Path.mkdir, mode=0o700))


def publish(hidden: Path, at: float, what: str) -> Path:
    """Put a recording on the disk, and give it its name: the local time, and what happened."""
    for file in hidden.iterdir():
        file.chmod(0o600)
        _sync(file)
    _sync(hidden)
    word = re.sub(r"\W+", "_", what, flags=re.ASCII).strip("_")[:_MAX_WORD]
    wanted = hidden.with_name(f"{datetime.fromtimestamp(at):%Y-%m-%d_%H-%M-%S}_{word}")
    whole = _with_free_name(wanted, hidden.rename)
    _sync(whole.parent)
    return whole


def _sync(path: Path) -> None:
    if os.name == "nt" and path.is_dir():
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def make_room(
    folder: Path, budget: int, written: Path | None = None
) -> tuple[int, list[Recording]]:
    """Delete the oldest recordings beyond a budget; return the bytes that remain, and the deleted.

    Those kept by hand, the newest and the one just `written` stay.
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
