"""The black box: keeps the last minute, and writes it when something happens, with what follows."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.recording.ring import Heard, Ring

AFTER = 5.0  # s that are recorded behind the last trigger
LONGEST = 300.0  # s from the first trigger to the end
PART = 600.0  # s of each bag where all is recorded
ALL = "all of it"  # why, of these
BUDGET = 1_000_000_000  # bytes of all recordings
KEPT = "kept"  # why, of one that was begun by hand
MOST_BYTES = 64_000_000  # of one recording, in memory
_SLOW = "recording not written: the disk is too slow"
_WAITING = 1  # recordings that may wait for the disk, beside the one that is written
_AGAIN = 10.0  # s between two looks whether a trouble is over


class _Open:
    """A recording that goes on."""

    def __init__(self, ring: Ring, clock: Clock, why: str, seconds: float = AFTER) -> None:
        now, self.at = clock.monotonic(), clock.now()
        self.begun, self.ends = now, now + seconds
        self.why: list[str] = [why]
        self.kept = False  # by hand
        self._ring, self._bytes = ring, 0
        self.heard: list[Heard] = []
        self.heard[:0] = ring.copy_to(self._take)

    def _take(self, heard: Heard, weight: int) -> None:
        self._bytes += weight
        if self._bytes < MOST_BYTES:
            self.heard.append(heard)

    def extend(self, now: float, why: str) -> None:
        """Something else happened."""
        self.ends = min(now + AFTER, self.begun + LONGEST)
        if why not in self.why:
            self.why.append(why)

    def end(self) -> None:
        """It is complete."""
        self._ring.leave(self._take)

    @property
    def is_full(self) -> bool:
        """True when nothing more is taken."""
        return self._bytes >= MOST_BYTES


class BlackBox:
    """`hear` is called on any thread, all else on the loop; a thread of its own writes."""

    def __init__(
        self,
        folder: Path,
        clock: Clock,
        note: Callable[[str, str, str], None],
        attached: Callable[[float, float], Mapping[str, str]],
        budget: int = BUDGET,
        all_to: Path | None = None,
    ) -> None:
        """`note(level, source, text)` adds an event.

        `attached(begin, end)` are texts to be kept in a recording of that time, by name. `all_to`:
        besides, all is recorded, in bags of that name; the next ones have a number behind it.
        """
        self._folder, self._clock, self._note, self._budget = folder, clock, note, budget
        self._attached = attached
        self.ring = Ring()
        self._open: _Open | None = None
        self._all_to = all_to
        self._all: _Open | None = None
        self.failure = ""  # why the last one could not be written
        self._full = ""  # that the budget is nearly used
        self._looked = 0.0  # monotonic s, whether the trouble is over
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._thread: threading.Thread | None = None

    def hear(self, topic: str, message: Any) -> None:
        """Keep a message that was received now."""
        now = self._clock.monotonic()
        self.ring.add(Heard(int(self._clock.now() * 1e9), topic, message), now)

    @property
    def trouble(self) -> str:
        """What an operator is to know, or an empty string."""
        return f"RECORDING NOT WRITTEN: {self.failure}" if self.failure else self._full

    def trigger(self, why: str, *, by_hand: bool = False) -> None:
        """Something happened: record the last minute, and what follows."""
        now = self._clock.monotonic()
        if self._open is None:
            self._open = _Open(self.ring, self._clock, why)
        else:
            self._open.extend(now, why)
        self._open.kept = self._open.kept or by_hand

    def look(self) -> None:
        """Have what is complete written."""
        now = self._clock.monotonic()
        if self._all_to is not None and self._all is None:  # it begins with the minute before
            self._all = _Open(self.ring, self._clock, ALL, PART)
        for opened in (self._open, self._all):
            if opened is not None and (now >= opened.ends or opened.is_full):
                self._hand_over(opened)
        if self.trouble and self._thread is not None and now - self._looked > _AGAIN:
            self._looked = now
            if self._jobs.empty():
                self._jobs.put(self._look_again)

    def _hand_over(self, opened: _Open) -> None:
        to = self._all_to if opened is self._all else None
        if to is None:
            self._open = None
        else:
            self._all = None
        opened.end()
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="black box", daemon=True)
            self._thread.start()
        if self._jobs.qsize() > _WAITING:
            self.failure = "the disk is too slow"
        else:
            self._jobs.put(partial(self._write, opened, to))

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            job()

    def _write(self, opened: _Open, to: Path | None) -> None:
        from archo_tui.recording import bag, store

        about = {"why": ", ".join(opened.why), "kept": "yes" if opened.kept else "no"}
        heard = opened.heard
        times = [one.time / 1e9 for one in heard] or [opened.at]

        def fill(folder: Path) -> None:
            written = bag.write(folder, heard, about, **self._attached(min(times), max(times)))
            if written.left_out:
                said = f"{written.left_out} messages are not in the recording: {written.why}"
                self._note("WARN", "console", said)

        try:
            if to is None:
                made = store.add(self._folder, opened.at, opened.why[0], fill)
            else:
                made = store.write(to, fill)
        except Exception as error:  # whatever it is, the console lives on
            self.failure = self._said(error, to)
            return
        self.failure = ""
        self._note("INFO", "console", f"recorded {made.name}: {about['why']}")
        try:
            self._make_room()
        except Exception as error:
            self._full = f"OLD RECORDINGS ARE NOT DELETED: {self._said(error)}"

    def _look_again(self) -> None:
        """Somebody may have made room."""
        from archo_tui.recording import store

        try:
            store.try_out(self._folder)
        except OSError as error:
            self.failure = self._said(error)
            return
        self.failure = ""
        try:
            self._make_room()
        except Exception as error:
            self._full = f"OLD RECORDINGS ARE NOT DELETED: {self._said(error)}"

    def _make_room(self) -> None:
        from archo_tui.recording import store

        size, gone = store.make_room(self._folder, self._budget)
        self._full = ""
        for one in gone:
            self._note("WARN", "console", f"recording {one.name} deleted: room was needed")
        if size >= store.ALARM_AT * self._budget:
            limit = f"{size / 1e6:.0f} of {self._budget / 1e6:.0f} MB"
            kept = size > self._budget
            then = "delete some that were kept by hand" if kept else "then the oldest are deleted"
            self._full = f"RECORDINGS TAKE {limit}: {then}"

    def _said(self, error: Exception, where: Path | None = None) -> str:
        if isinstance(error, OSError):
            return f"{error.strerror or error}: {error.filename or where or self._folder}"
        return in_one_line(error)

    def end(self) -> None:
        """Begin to write what is not complete, too."""
        for opened in (self._open, self._all):
            if opened is not None:
                self._hand_over(opened)

    def close(self, seconds: float) -> str:
        """Wait so long for what is being written; returns why it failed, or an empty string."""
        if self._thread is None:
            return ""
        self._jobs.put(None)
        self._thread.join(seconds)
        if self._thread.is_alive():
            return _SLOW
        return f"recording not written: {self.failure}" if self.failure else ""
