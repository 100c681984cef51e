"""The black box: keeps the last minute, and writes recordings on a thread of its own."""

from __future__ import annotations

import queue
import shutil
import threading
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.recordings import store
from archo_tui.recordings.bag import BagWriter, LazyMessage, ReceivedMessage

SPAN = 60.0  # Seconds.
RING_BYTES = 16_000_000
_MAX_LATCHED = 1_000_000  # Bytes of a message that is kept beyond its time.
# The topics whose messages are events; of all others the last message is the current state.
_EVENT_TOPICS = ("/rosout", "/parameter_events", "/_action/feedback", "/archo_tui/journal")


Listener = Callable[[ReceivedMessage], None]


class Ring:
    """A buffer of the last minute of messages, at most 16 MB of them. Thread-safe.

    The last message of each topic is kept beyond its time, unless it is larger than 1 MB or tells
    an event, as those of `/rosout` do: it shows the state of things at the beginning of a
    recording.
    """

    def __init__(self, span: float = SPAN, max_bytes: int = RING_BYTES) -> None:
        self._span, self._max_bytes = round(span * 1e9), max_bytes
        self._lock = threading.Lock()
        self._messages: deque[ReceivedMessage] = deque()
        self._bytes = 0
        # The last message of each topic that has become too old for the deque.
        self._latched: dict[str, ReceivedMessage] = {}
        self._listeners: list[Listener] = []

    def add(self, received: ReceivedMessage) -> None:
        """Keep a message, drop the oldest beyond the time or the bytes, and call the listeners."""
        with self._lock:
            self._messages.append(received)
            self._bytes += received.bytes
            cutoff = received.time - self._span
            while self._bytes > self._max_bytes or (
                self._messages and self._messages[0].time < cutoff
            ):
                oldest = self._messages.popleft()
                self._bytes -= oldest.bytes
                if oldest.bytes <= _MAX_LATCHED and not oldest.topic.endswith(_EVENT_TOPICS):
                    self._latched[oldest.topic] = oldest
            for listener in self._listeners:
                listener(received)

    def subscribe(self, listener: Listener) -> list[ReceivedMessage]:
        """Return the messages kept so far; pass all that follow to `listener`, under the lock."""
        with self._lock:
            self._listeners.append(listener)
            latched = [*self._latched.values()]
            if self._messages:
                begin = self._messages[0].time
                latched = [message._replace(time=begin) for message in latched]
            return [*latched, *self._messages]

    def unsubscribe(self, listener: Listener) -> None:
        with self._lock:
            self._listeners.remove(listener)

    @property
    def bytes(self) -> int:
        """The memory that the messages of the last minute take, approximately."""
        return self._bytes


OnWritten = Callable[[str, str], None]  # The recording's name, or "" and why there is none.
SECONDS_AFTER = 5.0  # Recorded after the last trigger.
BEGUN = f"the last {SPAN:g} s are recorded, and the next {SECONDS_AFTER:g} s"
MAX_SECONDS = 300.0  # From the first trigger to the end of a recording.
CONTINUOUS_SPAN = 600.0  # Seconds in each bag if everything is recorded.
ALL = "all of it"  # The reason in the metadata of such a bag.
MAX_BYTES = 64_000_000  # Bytes of one recording that wait in memory.
_FLUSH_PERIOD = 0.9  # A little less than the second between two calls of `tick`.
_SLOW = "the disk is too slow"
_MAX_WAITING = 1  # Recordings that may wait while another is being written.
_RETRY = 10.0  # Seconds between two tries to record everything after a failure.


def _since(clock: Clock) -> float:
    return clock.now() - clock.monotonic()


class _Recording:
    """A recording that goes on: the messages in the ring, and those that follow.

    One of an event is written as a whole when it has ended, by the clock of then. One of
    everything, whose first folder is `to`, is written each second, by the clock of its beginning.
    """

    def __init__(self, ring: Ring, clock: Clock, why: str, seconds: float, to: Path | None) -> None:
        self.why, self.kept, self.to = [why], False, to
        self.on_written: list[OnWritten] = []
        self.begun = clock.monotonic()
        self.ends = self.begun + seconds
        # Unix minus monotonic time, by which all its times are: of an event, as it has ended.
        self.since = _since(clock)
        self.is_full = False  # True once messages are dropped, as MAX_BYTES of them wait.
        self.flushed = 0.0  # Monotonic time of the last order to write.
        self.is_waiting = False  # True while such an order waits for the writing thread.
        self.failed: float | None = None  # Monotonic time at which writing failed.
        self.writer: BagWriter | None = None
        self.unfinished: Path | None = None  # The folder while nothing of use is in it.
        self._clock, self._ring, self._lock, self._bytes = clock, ring, threading.Lock(), 0
        self._is_collecting = True
        with self._lock:
            self._messages = ring.subscribe(self._on_message)

    def _on_message(self, message: ReceivedMessage) -> None:
        with self._lock:
            self._bytes += message.bytes
            if self._bytes < MAX_BYTES:
                self._messages.append(message)
            else:
                self.is_full = True

    def extend(self, now: float, why: str) -> None:
        """Prolong it to SECONDS_AFTER from now, but to MAX_SECONDS in all at most."""
        self.ends = min(now + SECONDS_AFTER, self.begun + MAX_SECONDS)
        if why not in self.why:
            self.why.append(why)

    def take_messages(self) -> list[ReceivedMessage]:
        """Return the messages received since the last call, and forget them."""
        with self._lock:
            messages, self._messages, self._bytes = self._messages, [], 0
        return messages

    def stop_collecting(self) -> None:
        """Take no more messages; a second call does nothing. Any thread."""
        with self._lock:
            is_collecting, self._is_collecting = self._is_collecting, False
        if is_collecting:
            self._ring.unsubscribe(self._on_message)
            if self.to is None:
                self.since = _since(self._clock)


class BlackBox:
    """The recorder of a console: the last minute in memory, and bags written from it.

    `receive` may be called on any thread, everything else on the event loop. The writing thread
    begins with the first recording.
    """

    def __init__(
        self,
        folder: Path,
        clock: Clock,
        add_event: Callable[[str, str, str], None],  # Level, source, text; called on any thread.
        attachments: Callable[[], Mapping[str, str]],  # By name.
        budget: int = store.BUDGET,
        record_all_to: Path | None = None,
    ) -> None:
        """Keep what `receive` gets; with `record_all_to` write all of it there, from `tick` on."""
        self._folder, self._clock, self._budget = folder, clock, budget
        self._add_event, self._attachments = add_event, attachments
        self.ring = Ring()
        self._event: _Recording | None = None
        self._all: _Recording | None = None
        self._all_to = record_all_to
        self.failure = ""  # Why the last recording could not be written; "": the disk works.
        self._all_failure = ""  # The same of the recording of everything.
        self._budget_warning = ""
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._thread: threading.Thread | None = None

    def receive(self, topic: str, message_class: Any, content: bytes | LazyMessage) -> None:
        """Add a message that was received now to the last minute, and to recordings that go on."""
        now = int(self._clock.monotonic() * 1e9)
        self.ring.add(ReceivedMessage(now, topic, message_class, content))

    @property
    def trouble(self) -> str:
        """A warning that recordings are not written or fill their budget; "" for none."""
        failure = self.failure or self._all_failure
        return f"RECORDING NOT WRITTEN: {failure}" if failure else self._budget_warning

    def trigger(
        self, why: str, *, by_hand: bool = False, on_written: OnWritten | None = None
    ) -> None:
        """Record the last minute and the next 5 s; prolong a recording that goes on to that end."""
        if self._event is None:
            self._event = _Recording(self.ring, self._clock, why, SECONDS_AFTER, None)
        else:
            self._event.extend(self._clock.monotonic(), why)
        self._event.kept = self._event.kept or by_hand
        if on_written is not None:
            self._event.on_written.append(on_written)

    def tick(self) -> None:
        """Have written what is due, about each second; drop a recording if two others wait."""
        now = self._clock.monotonic()
        if self._event is not None and (now >= self._event.ends or self._event.is_full):
            self._finish_event(self._event)
        if self._all_to is not None:
            self._tick_all(now, self._all_to)

    def _tick_all(self, now: float, to: Path) -> None:
        """Hand over the messages of the last second; begin another bag after 10 min or failing."""
        current = self._all
        if current is not None and current.failed is not None:
            if now - current.failed < _RETRY:
                return
            current = None
        if current is None:  # Its first messages are the ring's last minute.
            current = self._all = _Recording(self.ring, self._clock, ALL, CONTINUOUS_SPAN, to)
        if current.is_full:
            self._all_failure = _SLOW
        if now >= current.ends:
            self._finish_all(current)
        elif now - current.flushed >= _FLUSH_PERIOD and not current.is_waiting:
            current.flushed, current.is_waiting = now, True
            self._submit(partial(self._write, current))

    def _finish_all(self, recording: _Recording) -> None:
        self._all = None
        recording.stop_collecting()
        self._submit(partial(self._write, recording, is_last=True))

    def _finish_event(self, recording: _Recording) -> None:
        self._event = None
        recording.stop_collecting()
        if self._jobs.qsize() > _MAX_WAITING + (self._all_to is not None):
            self._report_failure(recording, _SLOW)
        else:
            self._submit(partial(self._write, recording, is_last=True))

    def finish(self) -> None:
        """Hand the recordings that still go on to the writing thread, complete or not."""
        if self._event is not None:
            self._finish_event(self._event)
        if self._all is not None:
            self._finish_all(self._all)

    def close(self, seconds: float) -> str:
        """End the thread when all is written, or after so long; return what is not, or ""."""
        if self._thread is None:
            return ""
        self._jobs.put(None)
        self._thread.join(seconds)
        failure = _SLOW if self._thread.is_alive() else self.failure or self._all_failure
        return f"recording not written: {failure}" if failure else ""

    def _submit(self, job: Callable[[], None]) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="black box", daemon=True)
            self._thread.start()
        self._jobs.put(job)

    # On the writing thread, but for `_report_failure`.

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            job()

    def _write(self, recording: _Recording, *, is_last: bool = False) -> None:
        """Write the messages that came since the last call; never raise."""
        recording.is_waiting = False
        messages = recording.take_messages()
        if recording.failed is not None:
            return
        try:
            self._write_messages(recording, messages)
            name = self._complete(recording) if is_last else ""
        except Exception as error:  # Recording must never end the console.
            self._abandon(recording)
            self._report_failure(recording, self._describe_error(error, recording.to))
            return
        if recording.to is None:
            self.failure = ""
        elif not recording.is_full:
            self._all_failure = ""
        if not is_last:
            return
        self._add_event("INFO", "console", f"recorded {name}: {', '.join(recording.why)}")
        for on_written in recording.on_written:
            on_written(name, "")
        if recording.to is None:
            self._make_room(self._folder / name)

    def _write_messages(self, recording: _Recording, messages: list[ReceivedMessage]) -> None:
        to, writer = recording.to, recording.writer
        if writer is None:
            made = store.make_hidden(self._folder) if to is None else store.make_folder(to)
            recording.unfinished = made
            writer = recording.writer = BagWriter(made, recording.since)
            writer.add(messages)
            # Attached now, so that a bag without an end tells which robot it is of.
            writer.attach(self._attachments())
        elif to is not None:
            store.check_free(to.parent)
            writer.add(messages)
        if to is not None:
            if messages:
                writer.flush()
            recording.unfinished = None

    def _complete(self, recording: _Recording) -> str:
        writer = recording.writer
        assert writer is not None
        about = {"why": ", ".join(recording.why), "kept": "yes" if recording.kept else "no"}
        if recording.to is None:
            at = recording.begun + recording.since
            number = store.next_number(self._folder)
            about |= {"at": str(int(at * 1e9)), "number": str(number)}
            writer.finish(about)
            name = store.publish(writer.folder, at, recording.why[0]).name
        else:
            writer.finish(about)
            name = writer.folder.name
        if writer.left_out:
            text = f"{writer.left_out} messages are not in the recording: {writer.first_error}"
            self._add_event("WARN", "console", text)
        return name

    def _abandon(self, recording: _Recording) -> None:
        recording.stop_collecting()
        recording.failed = self._clock.monotonic()
        if recording.writer is not None:
            recording.writer.close()
        if recording.unfinished is not None:
            shutil.rmtree(recording.unfinished, ignore_errors=True)

    def _report_failure(self, recording: _Recording, why: str) -> None:
        if recording.to is not None:
            self._all_failure = why
            return
        self.failure = why
        for on_written in recording.on_written:
            on_written("", why)

    def _make_room(self, written: Path) -> None:
        """Delete the oldest recordings beyond the budget, with an event for each; warn near it."""
        try:
            size, gone = store.make_room(self._folder, self._budget, written)
        except Exception as error:
            self._budget_warning = f"OLD RECORDINGS ARE NOT DELETED: {self._describe_error(error)}"
            return
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
