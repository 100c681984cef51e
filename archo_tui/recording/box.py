"""The black box: decides what is recorded and until when, and writes it on a thread of its own."""

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
from archo_tui.recording.ring import SPAN, ReceivedMessage, Ring

if TYPE_CHECKING:
    from archo_tui.recording import bag

OnWritten = Callable[[str, str], None]  # The recording's name, or "" and why there is none.
SECONDS_AFTER = 5.0  # Recorded after the last trigger.
BEGUN = f"the last {SPAN:g} s are recorded, and the next {SECONDS_AFTER:g} s"
MAX_SECONDS = 300.0  # From the first trigger to the end of a recording.
CONTINUOUS_SPAN = 600.0  # Seconds in each bag if everything is recorded.
_FLUSH_PERIOD = 0.9  # A little less than the second between two calls of `tick`.
ALL = "all of it"  # The reason in the metadata of such a bag.
BUDGET = 1_000_000_000  # Bytes of all recordings together.
KEPT = "kept"  # The reason of a recording that the operator asked for.
MAX_BYTES = 64_000_000  # Bytes of one recording in memory.
_SLOW = "recording not written: the disk is too slow"
_MAX_WAITING = 1  # Recordings that may wait while another is being written.
_RETRY = 10.0  # Seconds between two tries after a failure.


class _EventRecording:
    """A recording in memory, from its first trigger until a few seconds after its last.

    It begins with the messages in the ring, and ends earlier at MAX_SECONDS or MAX_BYTES.

    Attributes:
        begun: Monotonic time of the first trigger, in s.
        since: Unix time minus monotonic time at the first trigger, and at the end, in s. They
            differ if the clock was set; all times of the recording are by the later one.
        ends: Monotonic time at which the recording ends, in s.
        why: The reasons of the triggers, each once.
        kept: True if the operator asked for it.
        on_written: Called when the recording is written, or cannot be.
        messages: The messages, in the order of receiving.
    """

    def __init__(self, ring: Ring, clock: Clock, why: str) -> None:
        self._clock, now = clock, clock.monotonic()
        self.begun, self.ends = now, now + SECONDS_AFTER
        self.since = [_since(clock), _since(clock)]
        self.why: list[str] = [why]
        self.kept = False  # True if the operator asked for it.
        self.on_written: list[OnWritten] = []
        self._ring, self._bytes = ring, 0
        self.messages: list[ReceivedMessage] = []
        self.messages[:0] = ring.subscribe(self._on_message)

    def _on_message(self, message: ReceivedMessage, weight: int) -> None:
        """Add a message, or drop it if MAX_BYTES are reached; `is_full` is True from then on."""
        self._bytes += weight
        if self._bytes < MAX_BYTES:
            self.messages.append(message)

    def extend(self, now: float, why: str) -> None:
        """Prolong the recording to SECONDS_AFTER from now, but to MAX_SECONDS in all at most.

        Args:
            now: Monotonic time, in s.
            why: The reason, which is added if it is a new one.
        """
        self.ends = min(now + SECONDS_AFTER, self.begun + MAX_SECONDS)
        if why not in self.why:
            self.why.append(why)

    def stop_collecting(self) -> None:
        """Stop collecting messages; call it once."""
        self._ring.unsubscribe(self._on_message)
        self.since[1] = _since(self._clock)

    @property
    def is_full(self) -> bool:
        """Return True if the recording takes no further messages, for lack of memory."""
        return self._bytes >= MAX_BYTES


class _ContinuousBag:
    """A bag to which every message is written as it comes, beginning with those in the ring.

    Attributes:
        ends: Monotonic time at which the next bag begins, in s.
        flushed: Monotonic time of the last order to write, in s.
        writer: The bag's writer, once the first messages are written.
        since: Unix time minus monotonic time, in s, by which all times of the bag are.
        begun: Unix time of its first message, in s.
        failed: Monotonic time at which writing failed; None while it works.
        is_waiting: True while a job for this bag waits for the writing thread.
        folder: The bag's folder until the first messages are on the disk, to delete it if that
            fails; None before and afterwards.
        left_out: True if messages were dropped because the disk was too slow.
    """

    def __init__(self, ring: Ring, clock: Clock) -> None:
        self.ends, self.since = clock.monotonic() + CONTINUOUS_SPAN, _since(clock)
        self.flushed = 0.0
        self.writer: bag.BagWriter | None = None
        self.begun = 0.0
        self.failed: float | None = None
        self.is_waiting = False
        self.folder: Path | None = None
        self._ring, self._lock, self._bytes = ring, threading.Lock(), 0
        self._listens = True
        self._messages: list[ReceivedMessage] = []
        self.left_out = False
        with self._lock:
            self._messages[:0] = ring.subscribe(self._on_message)

    def _on_message(self, message: ReceivedMessage, weight: int) -> None:
        """Add a message, or drop it and set `left_out` while MAX_BYTES wait to be written."""
        with self._lock:
            self._bytes += weight
            if self._bytes < MAX_BYTES:
                self._messages.append(message)
            else:
                self.left_out = True

    def take_messages(self) -> list[ReceivedMessage]:
        """Return the messages received since the last call, and forget them."""
        with self._lock:
            messages, self._messages, self._bytes = self._messages, [], 0
        return messages

    def stop_collecting(self) -> None:
        """Stop collecting messages; a second call does nothing. Any thread."""
        with self._lock:
            listens, self._listens = self._listens, False
        if listens:
            self._ring.unsubscribe(self._on_message)


def _since(clock: Clock) -> float:
    return clock.now() - clock.monotonic()


class BlackBox:
    """The recorder of a console: the last minute in memory, and bags written from it.

    `receive` may be called on any thread, everything else on the event loop. Files are written on a
    thread of its own, which begins with the first recording.

    Attributes:
        ring: The messages of the last minute.
        failure: Why the last recording could not be written; "" if it was, or the disk works again.
    """

    def __init__(
        self,
        folder: Path,
        clock: Clock,
        note: Callable[[str, str, str], None],
        attached: Callable[[float, float], Mapping[str, str]],
        budget: int = BUDGET,
        record_all_to: Path | None = None,
    ) -> None:
        """Create the recorder, which keeps in memory what `receive` gets from now on.

        Args:
            folder: The folder of recordings; it is made when the first one is written.
            clock: The clock of all times here.
            note: Called on any thread with level, source and text of an event for the operator.
            attached: Called on the writing thread with the Unix times of begin and end; returns the
                text of each attachment by its name.
            budget: The bytes that all recordings in `folder` may take together.
            record_all_to: A folder to which every message is recorded besides, from the first
                `tick` on; each bag after the first has a number behind this name. None: a trigger
                alone makes recordings.
        """
        self._folder, self._clock, self._add_event, self._budget = folder, clock, note, budget
        self._get_attachments = attached
        self.ring = Ring()
        self._event: _EventRecording | None = None
        self._continuous_to = record_all_to
        self._continuous: _ContinuousBag | None = None
        self._continuous_failure = ""  # Why the continuous bag is not written; "": it is.
        self.failure = ""  # Why the last recording could not be written; "": it was.
        self._budget_warning = ""  # For the operator; "": the budget is not nearly used.
        self._retried = 0.0  # Monotonic time, in s.
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._thread: threading.Thread | None = None

    def receive(self, topic: str, message: Any) -> None:
        """Add a message that was received now to the last minute, and to recordings that go on.

        It may be a LazyMessage.
        """
        now = self._clock.monotonic()
        self.ring.add(ReceivedMessage(int(now * 1e9), topic, message), now)

    @property
    def trouble(self) -> str:
        """Return a warning that recordings are not written or fill their budget; "" for none."""
        failure = self.failure or self._continuous_failure
        return f"RECORDING NOT WRITTEN: {failure}" if failure else self._budget_warning

    def trigger(
        self, why: str, *, by_hand: bool = False, on_written: OnWritten | None = None
    ) -> None:
        """Record the last minute and the next 5 s; prolong a recording that goes on to that end.

        A recording ends 300 s after its first trigger at the latest. `tick` and `finish` end it.

        Args:
            why: The reason, in a few words.
            by_hand: True if the operator asked for it: the whole recording is not deleted for room.
            on_written: Called on any thread with the recording's name and "" when it is on the
                disk, or with "" and the reason if it could not be written.
        """
        now = self._clock.monotonic()
        if self._event is None:
            self._event = _EventRecording(self.ring, self._clock, why)
        else:
            self._event.extend(now, why)
        self._event.kept = self._event.kept or by_hand
        if on_written is not None:
            self._event.on_written.append(on_written)

    def tick(self) -> None:
        """End a recording whose time is over or that is full, and let the writing thread write it.

        A recording is dropped, and `trouble` and `on_written` say so, if two others still wait for
        a slow disk. Also hand the messages of the last second to the writing thread if everything
        is recorded, and after a failure or near the budget, try to write and to make room again
        each 10 s. Call it about each second.
        """
        now = self._clock.monotonic()
        if self._event is not None and (now >= self._event.ends or self._event.is_full):
            self._finish_event(self._event)
        is_in_trouble = self._thread is not None and bool(self.failure or self._budget_warning)
        if is_in_trouble and now - self._retried > _RETRY:
            self._retried = now
            if self._jobs.empty():
                self._jobs.put(self._retry_disk)
        if self._continuous_to is not None:
            self._tick_continuous(now, self._continuous_to)

    def _tick_continuous(self, now: float, to: Path) -> None:
        """Hand the messages of the last second to the writing thread; begin a bag if none is on.

        A bag ends after 10 minutes. A bag that failed is replaced by a new one after 10 s.

        Args:
            now: Monotonic time, in s.
            to: The path of the first bag's folder.
        """
        if self._continuous is not None and self._continuous.failed is not None:
            if now - self._continuous.failed < _RETRY:
                return
            self._continuous = None
        if self._continuous is None:  # Its first messages are the ring's last minute.
            self._continuous = _ContinuousBag(self.ring, self._clock)
        current = self._continuous
        if current.left_out:
            self._continuous_failure = "the disk is too slow"
        if now >= current.ends:
            self._end_continuous(current, to)
        elif now - current.flushed >= _FLUSH_PERIOD and not current.is_waiting:
            current.flushed, current.is_waiting = now, True
            self._start_thread()
            self._jobs.put(partial(self._append, current, to))

    def _end_continuous(self, current: _ContinuousBag, to: Path) -> None:
        self._continuous = None
        current.stop_collecting()
        self._start_thread()
        self._jobs.put(partial(self._append, current, to, is_last=True))

    def _finish_event(self, recording: _EventRecording) -> None:
        self._event = None
        recording.stop_collecting()
        self._start_thread()
        if self._jobs.qsize() > _MAX_WAITING + (self._continuous_to is not None):
            self._report_failure(recording, "the disk is too slow")
        else:
            self._jobs.put(partial(self._write_event, recording))

    def _report_failure(self, recording: _EventRecording, why: str) -> None:
        self.failure = why
        for on_written in recording.on_written:
            on_written("", why)

    def _start_thread(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="black box", daemon=True)
            self._thread.start()

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            job()

    def _append(self, current: _ContinuousBag, to: Path, *, is_last: bool = False) -> None:
        """Write the messages that came since the last call, on the writing thread; never raise.

        The first call creates the bag. A failure is reported by `trouble`, and ends the bag.

        Args:
            current: The bag.
            to: The path of the bag's folder; if that exists, a number is put behind its name.
            is_last: True to end the bag after these messages, and tell the operator of it.
        """
        from archo_tui.recording import bag, store

        current.is_waiting = False
        messages = current.take_messages()
        if current.failed is not None:
            return
        try:
            if current.writer is None:
                first = messages[0].time / 1e9 if messages else self._clock.monotonic()
                current.begun = first + current.since
                current.folder = store.make_folder(to)
                current.writer = bag.BagWriter(current.folder, current.since)
                current.writer.add(messages)
                # Attached now, so that a bag without an end tells which robot it is of.
                current.writer.attach(self._get_attachments(current.begun, current.begun))
            else:
                store.check_free(to.parent)
                current.writer.add(messages)
            if messages:
                current.writer.flush()
            current.folder = None
            if is_last:
                about = {"why": ALL, "kept": "no"}
                self._report_left_out(
                    current.writer.finish(about, self._final_attachments(current))
                )
                self._add_event("INFO", "console", f"recorded {current.writer.folder.name}: {ALL}")
        except Exception as error:  # Recording must never end the console.
            self._continuous_failure = self._describe_error(error, to)
            self._abandon(current)
            return
        if not current.left_out:
            self._continuous_failure = ""

    def _final_attachments(self, current: _ContinuousBag) -> dict[str, str]:
        """Return the attachments that have grown since the bag began: the journal."""
        was_set = _since(self._clock) - current.since  # By so much the clock was set, in s.
        end = self._clock.monotonic() + current.since
        attached = self._get_attachments(current.begun + min(was_set, 0), end + max(was_set, 0))
        return {name: attached[name] for name in attached if name.startswith("journal")}

    def _abandon(self, current: _ContinuousBag) -> None:
        """End a bag that cannot be written; `_tick_continuous` begins a new one later.

        Its folder stays, but is deleted if it holds nothing of use yet.
        """
        current.stop_collecting()
        current.failed = self._clock.monotonic()
        if current.writer is not None:
            current.writer.close()
        if current.folder is not None:  # The bag holds nothing of use yet.
            shutil.rmtree(current.folder, ignore_errors=True)

    def _report_left_out(self, result: bag.WriteResult) -> None:
        if result.left_out:
            text = f"{result.left_out} messages are not in the recording: {result.first_error}"
            self._add_event("WARN", "console", text)

    def _write_event(self, recording: _EventRecording) -> None:
        """Write a recording to the disk, then delete the oldest ones beyond the budget.

        Writing thread only. `on_written` and an event tell the operator. A failure is kept and
        passed to `on_written`, never raised.
        """
        from archo_tui.recording import bag, store

        about = {"why": ", ".join(recording.why), "kept": "yes" if recording.kept else "no"}
        since, messages = recording.since[-1], recording.messages
        at = recording.begun + since
        about["at"] = str(int(at * 1e9))
        times = [message.time / 1e9 for message in messages] or [recording.begun]

        def fill(folder: Path) -> None:
            about["number"] = str(store.next_number(self._folder))
            # The journal has its lines by the clock as it was.
            begin, end = min(times) + min(recording.since), max(times) + max(recording.since)
            attached = self._get_attachments(begin, end)
            self._report_left_out(bag.write(folder, messages, about, since, **attached))

        try:
            made = store.add(self._folder, at, recording.why[0], fill)
        except Exception as error:  # Recording must never end the console.
            self._report_failure(recording, self._describe_error(error))
            return
        self.failure = ""
        self._add_event("INFO", "console", f"recorded {made.name}: {about['why']}")
        for on_written in recording.on_written:
            on_written(made.name, "")
        try:
            self._make_room(made)
        except Exception as error:
            self._budget_warning = f"OLD RECORDINGS ARE NOT DELETED: {self._describe_error(error)}"

    def _retry_disk(self) -> None:
        """Clear `failure` and make room if the disk takes data again, else set `failure` anew.

        Writing thread only.
        """
        from archo_tui.recording import store

        try:
            store.check_writable(self._folder)
        except OSError as error:
            self.failure = self._describe_error(error)
            return
        self.failure = ""
        try:
            self._make_room()
        except Exception as error:
            self._budget_warning = f"OLD RECORDINGS ARE NOT DELETED: {self._describe_error(error)}"

    def _make_room(self, written: Path | None = None) -> None:
        """Delete the oldest recordings beyond the budget, with an event for each.

        From 90 % of the budget on, set the warning that `trouble` returns, else clear it.

        Args:
            written: The recording that was written last, which is not deleted; None for none.

        Raises:
            OSError: The disk refuses it.
        """
        from archo_tui.recording import store

        size, gone = store.make_room(self._folder, self._budget, written)
        self._budget_warning = ""
        for deleted in gone:
            self._add_event("WARN", "console", f"recording {deleted.name} deleted: room was needed")
        if size >= store.WARN_AT * self._budget:
            limit = f"{size / 1e6:.0f} of {self._budget / 1e6:.0f} MB"
            kept = size > self._budget
            then = "delete some that were kept by hand" if kept else "then the oldest are deleted"
            self._budget_warning = f"RECORDINGS TAKE {limit}: {then}"

    def _describe_error(self, error: Exception, where: Path | None = None) -> str:
        if isinstance(error, OSError):
            return f"{error.strerror or error}: {error.filename or where or self._folder}"
        return in_one_line(error)

    def finish(self) -> None:
        """Hand the recordings that still go on to the writing thread, complete or not.

        `close` then waits until they are written.
        """
        if self._event is not None:
            self._finish_event(self._event)
        if self._continuous is not None and self._continuous_to is not None:
            self._end_continuous(self._continuous, self._continuous_to)

    def close(self, seconds: float) -> str:
        """Wait until all that was handed to the writing thread is written, and end that thread.

        Args:
            seconds: The longest wait.

        Returns:
            Why the last recording was not written, or that the disk was too slow; "" if all is
            well, or nothing was to be written.
        """
        if self._thread is None:
            return ""
        self._jobs.put(None)
        self._thread.join(seconds)
        if self._thread.is_alive():
            return _SLOW
        failure = self.failure or self._continuous_failure
        return f"recording not written: {failure}" if failure else ""
