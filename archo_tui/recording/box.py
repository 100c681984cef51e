"""The black box: keeps the last minute, and writes it when something happens, with what follows."""

from __future__ import annotations

import queue
import shutil
import threading
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.recording.ring import SPAN, Heard, Ring

if TYPE_CHECKING:
    from archo_tui.recording import bag

Written = Callable[[str, str], None]  # the name of a recording, or why it is none
AFTER = 5.0  # s that are recorded behind the last trigger
BEGUN = f"the last {SPAN:g} s are recorded, and the next {AFTER:g} s"
LONGEST = 300.0  # s from the first trigger to the end
PART = 600.0  # s of each bag where all is recorded
_FLUSH = 0.9  # s between two times at which what came for it is put on the disk: each tick of 1 s
ALL = "all of it"  # why, of these
BUDGET = 1_000_000_000  # bytes of all recordings
KEPT = "kept"  # why, of one that was begun by hand
MOST_BYTES = 64_000_000  # of one recording, in memory
_SLOW = "recording not written: the disk is too slow"
_WAITING = 1  # recordings that may wait for the disk, beside the one that is written
_AGAIN = 10.0  # s between two looks whether a trouble is over


class _Open:
    """A recording that goes on."""

    def __init__(self, ring: Ring, clock: Clock, why: str) -> None:
        now, self.at = clock.monotonic(), clock.now()
        self.begun, self.ends = now, now + AFTER
        self.why: list[str] = [why]
        self.kept = False  # by hand
        self.written: list[Written] = []  # told what became of it, on the thread that writes
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


class _All:
    """A bag that everything is written to while it comes."""

    def __init__(self, ring: Ring, clock: Clock) -> None:
        self.ends = clock.monotonic() + PART
        self.flushed = 0.0  # monotonic s
        self.writer: bag.BagWriter | None = None  # from the first piece on
        self.begun = 0.0  # Unix time of its first message
        self.failed: float | None = None  # when it could not be written on, monotonic s
        self.is_waiting = False  # for the thread that writes
        self.folder: Path | None = None  # until something of it is on the disk
        self._ring, self._lock, self._bytes = ring, threading.Lock(), 0
        self._listens = True
        self._heard: list[Heard] = []
        self.left_out = False  # something came that the disk was too slow for
        with self._lock:
            self._heard[:0] = ring.copy_to(self._take)

    def _take(self, heard: Heard, weight: int) -> None:
        with self._lock:
            self._bytes += weight
            if self._bytes < MOST_BYTES:
                self._heard.append(heard)
            else:
                self.left_out = True

    def piece(self) -> list[Heard]:
        """Return what came since the last call."""
        with self._lock:
            piece, self._heard, self._bytes = self._heard, [], 0
        return piece

    def end(self) -> None:
        """Take nothing more. Any thread."""
        with self._lock:
            listens, self._listens = self._listens, False
        if listens:
            self._ring.leave(self._take)


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
        self._all: _All | None = None
        self._all_failure = ""  # why not all is recorded
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
        failure = self.failure or self._all_failure
        return f"RECORDING NOT WRITTEN: {failure}" if failure else self._full

    def trigger(self, why: str, *, by_hand: bool = False, written: Written | None = None) -> None:
        """Something happened: record the last minute, and what follows.

        `written(name, failure)` is called on another thread when that is on the disk, or is not.
        """
        now = self._clock.monotonic()
        if self._open is None:
            self._open = _Open(self.ring, self._clock, why)
        else:
            self._open.extend(now, why)
        self._open.kept = self._open.kept or by_hand
        if written is not None:
            self._open.written.append(written)

    def look(self) -> None:
        """Have what is complete written."""
        now = self._clock.monotonic()
        if self._open is not None and (now >= self._open.ends or self._open.is_full):
            self._hand_over(self._open)
        is_in_trouble = self._thread is not None and bool(self.failure or self._full)
        if is_in_trouble and now - self._looked > _AGAIN:
            self._looked = now
            if self._jobs.empty():
                self._jobs.put(self._look_again)
        if self._all_to is not None:
            self._record_all(now, self._all_to)

    def _record_all(self, now: float, to: Path) -> None:
        """Have what came written on, each second."""
        if self._all is not None and self._all.failed is not None:
            if now - self._all.failed < _AGAIN:
                return
            self._all = None
        if self._all is None:  # it begins with the minute before
            self._all = _All(self.ring, self._clock)
        part = self._all
        if part.left_out:
            self._all_failure = "the disk is too slow"
        if now >= part.ends:
            self._end_all(part, to)
        elif now - part.flushed >= _FLUSH and not part.is_waiting:
            part.flushed, part.is_waiting = now, True
            self._begin_thread()
            self._jobs.put(partial(self._write_on, part, to))

    def _end_all(self, part: _All, to: Path) -> None:
        self._all = None
        part.end()
        self._begin_thread()
        self._jobs.put(partial(self._write_on, part, to, is_last=True))

    def _hand_over(self, opened: _Open) -> None:
        self._open = None
        opened.end()
        self._begin_thread()
        if self._jobs.qsize() > _WAITING + (self._all_to is not None):
            self._not_written(opened, "the disk is too slow")
        else:
            self._jobs.put(partial(self._write, opened))

    def _not_written(self, opened: _Open, why: str) -> None:
        self.failure = why
        for written in opened.written:
            written("", why)

    def _begin_thread(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="black box", daemon=True)
            self._thread.start()

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            job()

    def _write_on(self, part: _All, to: Path, *, is_last: bool = False) -> None:
        """Write what came of everything."""
        from archo_tui.recording import bag, store

        part.is_waiting = False
        piece = part.piece()
        if part.failed is not None:
            return
        try:
            if part.writer is None:
                part.begun = piece[0].time / 1e9 if piece else self._clock.now()
                part.folder = store.begin(to)
                part.writer = bag.BagWriter(part.folder)
                part.writer.add(piece)
                # of what is cut off it is known which robot it is of
                part.writer.attach(self._attached(part.begun, part.begun))
            else:
                store.check_free(to.parent)
                part.writer.add(piece)
            if piece:
                part.writer.flush()
            part.folder = None
            if is_last:
                about = {"why": ALL, "kept": "no"}
                self._tell_left_out(part.writer.end(about, self._attachments(part)))
                self._note("INFO", "console", f"recorded {part.writer.folder.name}: {ALL}")
        except Exception as error:  # whatever it is, the console lives on
            self._all_failure = self._said(error, to)
            self._give_up(part)
            return
        if not part.left_out:
            self._all_failure = ""

    def _attachments(self, part: _All) -> dict[str, str]:
        """Return what is attached at the end: what changes meanwhile."""
        attached = self._attached(part.begun, self._clock.now())
        return {name: attached[name] for name in attached if name.startswith("journal")}

    def _give_up(self, part: _All) -> None:
        """Leave a bag that cannot be written on as it is; another one is tried later."""
        part.end()
        part.failed = self._clock.monotonic()
        if part.writer is not None:
            part.writer.close()
        if part.folder is not None:  # nothing of it is of use
            shutil.rmtree(part.folder, ignore_errors=True)

    def _tell_left_out(self, written: bag.Written) -> None:
        if written.left_out:
            said = f"{written.left_out} messages are not in the recording: {written.why}"
            self._note("WARN", "console", said)

    def _write(self, opened: _Open) -> None:
        from archo_tui.recording import bag, store

        about = {"why": ", ".join(opened.why), "kept": "yes" if opened.kept else "no"}
        heard = opened.heard
        times = [one.time / 1e9 for one in heard] or [opened.at]

        def fill(folder: Path) -> None:
            about["number"] = str(store.next_number(self._folder))
            attached = self._attached(min(times), max(times))
            self._tell_left_out(bag.write(folder, heard, about, **attached))

        try:
            made = store.add(self._folder, opened.at, opened.why[0], fill)
        except Exception as error:  # whatever it is, the console lives on
            self._not_written(opened, self._said(error))
            return
        self.failure = ""
        self._note("INFO", "console", f"recorded {made.name}: {about['why']}")
        for written in opened.written:
            written(made.name, "")
        try:
            self._make_room(made)
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

    def _make_room(self, written: Path | None = None) -> None:
        from archo_tui.recording import store

        size, gone = store.make_room(self._folder, self._budget, written)
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
        if self._open is not None:
            self._hand_over(self._open)
        if self._all is not None and self._all_to is not None:
            self._end_all(self._all, self._all_to)

    def close(self, seconds: float) -> str:
        """Wait so long for what is being written; returns why it failed, or an empty string."""
        if self._thread is None:
            return ""
        self._jobs.put(None)
        self._thread.join(seconds)
        if self._thread.is_alive():
            return _SLOW
        failure = self.failure or self._all_failure
        return f"recording not written: {failure}" if failure else ""
