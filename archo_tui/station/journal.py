"""The operator's log: JSON lines in the state folder, appended and flushed one by one.

Commands, how goals ended, what other consoles did: each with its text, and as data (`verb`,
`arguments`, `code`, see robot/acts.py). Alarms, warnings and worse. A disk that is full or
read-only is an alarm while it lasts, and tried again with every line.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import queue
import re
import threading
import time
from collections.abc import Iterator, Mapping
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from archo_tui.paths import make_folder
from archo_tui.regular_files import open_regular
from archo_tui.robot.outcome import Code
from archo_tui.system import lock, user_name

MAX_BYTES = 1_000_000  # then it is renamed to journal.jsonl.1, which replaces the older one
VERSION = 1  # of a line's form: it grows when what a name means changes
_ALIKE = 100  # lines of one node that differ in numbers only: as many are written one by one
_KINDS = 1000  # of them that are told apart
_WAITING = 1000  # lines that may wait for the disk
_STOP_TIMEOUT = 2.0  # s
_LOCK_TIMEOUT = 1.0  # s that another console may take to write a line, and more than it takes
_NUMBER = re.compile(r"\d+")
_LOOK = 0.005  # s between two looks whether it has


def unreleased_stop(file: Path, place: Mapping[str, object], since: float) -> float | None:
    """Return when the last confirmed STOP was that no confirmed release followed.

    Args:
        file: The journal; the older one beside it is read, too.
        place: What a line's `place` must be, see `Session`.
        since: Unix time; lines of before do not count.

    Returns:
        The Unix time; None if there is no such STOP, or the journal cannot be read.
    """
    found = None
    for path in (file.with_name(f"{file.name}.1"), file):
        try:
            with open(open_regular(path, os.O_RDONLY), "rb") as opened:
                lines = opened.read(2 * MAX_BYTES).splitlines()
        except OSError:
            continue
        for line in lines:
            entry = _command(line)
            if entry.get("place") != place or entry.get("code") != Code.DONE.value:
                continue
            time_of_it = _unix_time(entry.get("time"))
            if time_of_it >= since:
                found = time_of_it if entry.get("verb") == "stop" else None
    return found


def _command(line: bytes) -> dict[str, Any]:
    """Return the entry of a STOP or a release; an empty one for every other line."""
    try:
        entry = json.loads(line) if b'"place"' in line else None
    except ValueError:  # it was cut off, or is no text
        return {}
    if isinstance(entry, dict) and entry.get("verb") in ("stop", "release"):
        return entry
    return {}


def _unix_time(text: object) -> float:
    """Return the Unix time of a line; 0.0 for what is no time."""
    try:
        return datetime.fromisoformat(str(text)).timestamp()
    except (ValueError, OverflowError, OSError):
        return 0.0


class Flood:
    """Of a node's lines that differ in numbers; all of them would push everything else out."""

    def __init__(self) -> None:
        self._counts: dict[tuple[str, str], int] = {}  # the last one is the newest

    def spares(self, source: str, text: str) -> bool:
        """True for what is written: the first hundred, and then each thousandth."""
        alike = source, _NUMBER.sub("#", text)
        count = self._counts[alike] = self._counts.pop(alike, 0) + 1
        if len(self._counts) > _KINDS:
            del self._counts[next(iter(self._counts))]
        return count <= _ALIKE or count % 1000 == 0


class Journal:
    """Takes entries from any thread without waiting; a thread of its own writes them."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self.failure = ""  # why the last entry could not be written
        self._who = {
            "user": user_name(),
            "from": os.environ.get("SSH_CLIENT", "").partition(" ")[0],
        }
        self._entries: queue.Queue[dict[str, object] | None] = queue.Queue(_WAITING)
        self._lost = 0
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    def write(self, unix_time: float, kind: str, **what: object) -> None:
        """Add an entry; it is counted as lost when too many wait for the disk."""
        at = datetime.fromtimestamp(unix_time, timezone.utc).isoformat(timespec="milliseconds")
        try:
            self._entries.put_nowait({"v": VERSION, "time": at, "kind": kind, **self._who, **what})
        except queue.Full:
            self._lost += 1

    def close(self) -> None:
        """Write what is queued, but do not wait long for a disk that hangs."""
        try:
            self._entries.put(None, timeout=_STOP_TIMEOUT)
        except queue.Full:
            return
        self._thread.join(_STOP_TIMEOUT)

    def _run(self) -> None:
        while (entry := self._entries.get()) is not None:
            lost, self._lost = self._lost, 0
            if lost:
                entry |= {"lost_before": lost}
            try:
                self._append(json.dumps(entry, ensure_ascii=False))
            except OSError as error:
                self.failure = f"{error.strerror}: {error.filename or self._file}"
                self._lost += lost + 1
            else:
                self.failure = ""

    def _append(self, line: str) -> None:
        make_folder(self._file)
        with _locked(self._file.parent):  # other consoles write here too, and rotate
            if self._file.exists() and self._file.stat().st_size > MAX_BYTES:
                self._file.replace(self._file.with_name(f"{self._file.name}.1"))
            descriptor = open_regular(self._file, os.O_RDWR | os.O_APPEND | os.O_CREAT)
            try:
                _write_line(descriptor, line.encode("utf-8", "replace") + b"\n")
            finally:
                os.close(descriptor)


def _write_line(descriptor: int, line: bytes) -> None:
    """Append a line whole or not at all; one that something else left broken is ended first."""
    size = os.fstat(descriptor).st_size
    if size:
        os.lseek(descriptor, size - 1, os.SEEK_SET)
        if os.read(descriptor, 1) != b"\n":
            line = b"\n" + line
    try:
        while line:
            line = line[os.write(descriptor, line) :]
    except OSError:
        with contextlib.suppress(OSError):  # a device has no end to go back to
            os.ftruncate(descriptor, size)
        raise


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    path = folder / "journal.lock"
    descriptor = open_regular(path, os.O_RDWR | os.O_CREAT)
    try:
        end = time.monotonic() + _LOCK_TIMEOUT
        while not lock(descriptor):
            if time.monotonic() > end:
                raise OSError(errno.EAGAIN, "held by another process", str(path))
            time.sleep(_LOOK)
        yield
    finally:
        os.close(descriptor)
