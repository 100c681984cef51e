"""The operator's log: JSON lines in the state folder, each appended and flushed by itself.

It holds commands, the ends of goals and what other consoles did, each with its text and as data
(`verb`, `arguments`, `code`, see robot/state/audit_records.py), and alarms, warnings and errors.
While the disk is full or read-only there is an alarm, and each further line tries again.
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
from types import MappingProxyType
from typing import Any

from archo_tui.base.paths import make_folder
from archo_tui.base.regular_files import open_regular
from archo_tui.base.system import lock, user_name
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.events import Event, LineCounter

# Once the file is larger, it is renamed to journal.jsonl.1, which replaces the older one.
MAX_BYTES = 1_000_000
VERSION = 1  # Of the lines' format: grows if the meaning of a key changes.
_KINDS = {
    "YOU": "command",
    "SHELL": "command",
    "AI": "command",
    "GOAL": "goal",
    "PEER": "other console",
}  # Other levels are events.
# The counts of a repeated event that the journal notes.
_COUNTS = (1, 10, 100, 1000, 10_000, 100_000)
_ALL_WRITTEN = 100  # Similar lines of a node that are all written; more are thinned out.
_THINNED_TO = 1000  # One in as many is written then.
_WAITING = 1000  # Lines that may wait for the disk.
_STOP_TIMEOUT = 2.0  # Seconds.
_LOCK_TIMEOUT = 1.0  # Seconds to wait for another console that writes; far more than a line takes.
_NUMBER = re.compile(r"\d+")
_LOCK_POLL = 0.005  # Seconds between two attempts to lock.


def unreleased_stop(file: Path, place: Mapping[str, object], since: float) -> float | None:
    """Return the Unix time of the last confirmed STOP of a `place` without a release, or None."""
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
            unix_time = _unix_time(entry.get("time"))
            if unix_time >= since:
                found = unix_time if entry.get("verb") == "stop" else None
    return found


def _command(line: bytes) -> dict[str, Any]:
    try:
        entry = json.loads(line) if b'"place"' in line else None
    except ValueError:  # The line was cut off, or is not UTF-8.
        return {}
    if isinstance(entry, dict) and entry.get("verb") in ("stop", "release"):
        return entry
    return {}


def _unix_time(text: object) -> float:
    try:
        return datetime.fromisoformat(str(text)).timestamp()
    except (ValueError, OverflowError, OSError):
        return 0.0


class Journal:
    """The journal: takes entries from any thread without waiting, and writes them on its own."""

    def __init__(self, file: Path, place: Mapping[str, Any] = MappingProxyType({})) -> None:
        """Write to a file; `place`, the robot of this console, stands in the lines of a STOP."""
        self._file, self._place = file, place
        self._lines = LineCounter()  # Of nodes, by what is left without their numbers.
        self.failure = ""  # Why the last entry could not be written.
        self._who = {
            "user": user_name(),
            "from": os.environ.get("SSH_CLIENT", "").partition(" ")[0],
        }
        self._entries: queue.Queue[dict[str, object] | None] = queue.Queue(_WAITING)
        self._lost = 0
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    def record(self, event: Event) -> None:
        """Write an event, unless it is DEBUG, INFO, or one of many that differ in numbers only."""
        if event.level in ("DEBUG", "INFO") or event.count not in _COUNTS:
            return
        kind = _KINDS.get(event.level, "event")
        if kind == "event" and event.source != "console" and event.count == 1:
            like = event.source, _NUMBER.sub("#", event.text)
            count = self._lines.count(like, event.time)
            if count > _ALL_WRITTEN and count % _THINNED_TO:
                return
        what: dict[str, Any] = {"level": event.level, "source": event.source, "text": event.text}
        if event.command:
            what["command"] = event.command
        if event.audit_record is not None:
            what |= event.audit_record._asdict()
            if event.audit_record.verb in ("stop", "release"):
                what["place"] = self._place
        self.write(event.time, kind, **what, count=event.count)

    def write(self, unix_time: float, kind: str, **what: object) -> None:
        """Add an entry; if 1000 wait for the disk, only count it, as `lost_before` of the next."""
        at = datetime.fromtimestamp(unix_time, timezone.utc).isoformat(timespec="milliseconds")
        try:
            self._entries.put_nowait({"v": VERSION, "time": at, "kind": kind, **self._who, **what})
        except queue.Full:
            self._lost += 1

    def close(self) -> None:
        """Write what is queued, and end the thread; give up on a disk that hangs for 4 s."""
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
        with _locked(self._file.parent):  # Other consoles write and rename this file, too.
            if self._file.exists() and self._file.stat().st_size > MAX_BYTES:
                self._file.replace(self._file.with_name(f"{self._file.name}.1"))
            descriptor = open_regular(self._file, os.O_RDWR | os.O_APPEND | os.O_CREAT)
            try:
                _write_line(descriptor, line.encode("utf-8", "replace") + b"\n")
            finally:
                os.close(descriptor)


def _write_line(descriptor: int, line: bytes) -> None:
    """Append a line whole or not at all; a broken last line is ended first."""
    size = os.fstat(descriptor).st_size
    if size:
        os.lseek(descriptor, size - 1, os.SEEK_SET)
        if os.read(descriptor, 1) != b"\n":
            line = b"\n" + line
    try:
        while line:
            line = line[os.write(descriptor, line) :]
    except OSError:
        with contextlib.suppress(OSError):  # A device has no end to go back to.
            os.ftruncate(descriptor, size)
        raise


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the journal's lock; OSError if another process does for a second."""
    path = folder / "journal.lock"
    descriptor = open_regular(path, os.O_RDWR | os.O_CREAT)
    try:
        end = time.monotonic() + _LOCK_TIMEOUT
        while not lock(descriptor):
            if time.monotonic() > end:
                raise OSError(errno.EAGAIN, "held by another process", str(path))
            time.sleep(_LOCK_POLL)
        yield
    finally:
        os.close(descriptor)
