"""The operator's log: JSON lines in the state folder, appended and flushed one by one.

Commands with their outcome, alarms, warnings and worse. A disk that is full or read-only is
reported once, and tried again with every line.
"""

from __future__ import annotations

import getpass
import json
import os
import queue
import threading
from collections.abc import Callable
from datetime import datetime, timezone
from pathlib import Path

from archo_tui.paths import state_file

MAX_BYTES = 1_000_000  # then it is renamed to journal.jsonl.1, which replaces the older one
_WAITING = 1000  # lines that may wait for the disk
_STOP_TIMEOUT = 2.0  # s


def path() -> Path:
    """Where the journal is."""
    return state_file("journal.jsonl")


class Journal:
    """Takes entries from any thread without waiting; a thread of its own writes them."""

    def __init__(self, file: Path, on_failure: Callable[[str], None]) -> None:
        """`on_failure(reason)` is called once when nothing can be written, until something can."""
        self._file, self._on_failure = file, on_failure
        self._who = {"user": _user(), "from": os.environ.get("SSH_CLIENT", "").partition(" ")[0]}
        self._entries: queue.Queue[dict[str, object] | None] = queue.Queue(_WAITING)
        self._failing = False
        self._lost = 0
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    def write(self, unix_time: float, kind: str, **what: object) -> None:
        """Add an entry; it is counted as lost when too many wait for the disk."""
        at = datetime.fromtimestamp(unix_time, timezone.utc).isoformat(timespec="milliseconds")
        try:
            self._entries.put_nowait({"time": at, "kind": kind, **self._who, **what})
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
            if self._lost:
                entry, self._lost = entry | {"lost_before": self._lost}, 0
            try:
                self._append(json.dumps(entry, ensure_ascii=False))
            except OSError as error:
                if not self._failing:
                    self._on_failure(f"{self._file}: {error.strerror}")
                self._failing = True
            else:
                self._failing = False

    def _append(self, line: str) -> None:
        self._file.parent.mkdir(parents=True, exist_ok=True)
        if self._file.exists() and self._file.stat().st_size > MAX_BYTES:
            self._file.replace(self._file.with_name(f"{self._file.name}.1"))
        with self._file.open("a", encoding="utf-8", errors="replace") as file:
            file.write(f"{line}\n")


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # no such user, in a container
        return str(os.getuid())
