"""The black box: keeps the last minute, and writes recordings on a thread of its own."""

from __future__ import annotations

import math
import queue
import shutil
import threading
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from archo_tui.base.clock import Clock
from archo_tui.base.errors import in_one_line
from archo_tui.recordings import store
from archo_tui.recordings.bag import BagWriter, LazyMessage, ReceivedMessage

SPAN = 60.0  # Seconds.
RING_BYTES = 16_000_000
_MAX_LATCHED = 1_000_000  # Bytes of a message that is kept beyond its time.
# The topics whose messages are events; of all others the last message is the current state.
_EVENT_TOPICS = ("/rosout", "/parameter_events", "/_action/feedback", "/archo_tui/journal")
OnWritten = Callable[[str, str], None]  # The recording's name, or "" and why there is none.
SECONDS_AFTER = 5.0  # Recorded after the last trigger.
BEGUN = f"the last {SPAN:g} s are recorded, and the next {SECONDS_AFTER:g} s"
MAX_SECONDS = 300.0  # From the first trigger to the end of a recording.
CONTINUOUS_SPAN = 600.0  # Seconds in each bag if everything is recorded.
ALL = "all of it"  # The reason in the metadata of such a bag.
MAX_BYTES = 64_000_000  # Bytes that wait in memory for recordings.
_FLUSH_PERIOD = 0.9  # A little less than the second between two calls of `tick`.
_SLOW = "the disk is too slow"
_MAX_WAITING = 1  # Recordings that may wait while another is being written.
_RETRY = 10.0  # Seconds between two tries to record everything after a failure.


class Ring:
    """A buffer of the last minute of messages, at most 16 MB of them. Thread-safe.

    The last message of each topic is kept beyond its time, unless it is larger than 1 MB or tells
    an event, as those of `/rosout` do: it shows the state of things at the beginning of a
    recording. What recordings have not taken is kept as well, up to 64 MB.
    """

    def __init__(self, span: float = SPAN, max_bytes: int = RING_BYTES) -> None:
        self._span, self._max_bytes = round(span * 1e9), max_bytes
        self._lock = threading.Lock()
        self._messages: deque[ReceivedMessage] = deque()
        self.first = 0  # The number of the oldest message; they are counted from 0.
        self._held: float = math.inf  # The number of the first one that recordings want.
        self.bytes = 0  # The memory that the messages take, approximately.
        # The last message of each topic that has become too old for the deque.
        self._latched: dict[str, ReceivedMessage] = {}

    def add(self, received: ReceivedMessage) -> None:
        """Keep a message, and drop the oldest beyond the time or the bytes."""
        with self._lock:
            self._messages.append(received)
            self.bytes += received.bytes
            self._drop_old()

    def _drop_old(self) -> None:
        while self._messages:
            oldest, newest = self._messages[0], self._messages[-1]
            is_old = oldest.time < newest.time - self._span or self.bytes > self._max_bytes
            if not is_old or (self.first >= self._held and self.bytes <= MAX_BYTES):
                return
            self._messages.popleft()
            self.first += 1
            self.bytes -= oldest.bytes
            if oldest.bytes <= _MAX_LATCHED and not oldest.topic.endswith(_EVENT_TOPICS):
                self._latched[oldest.topic] = oldest

    def begin(self) -> tuple[list[ReceivedMessage], int]:
        """Return the last messages of silent topics, and the number of the oldest of all others.

        The former have the time of that. All from there on are held.
        """
        with self._lock:
            self._held = min(self._held, self.first)
            latched = [*self._latched.values()]
            if self._messages:
                begin = self._messages[0].time
                latched = [message._replace(time=begin) for message in latched]
            return latched, self.first

    def since(self, number: int) -> tuple[list[ReceivedMessage], int]:
        """Return the messages from a number on, and the number of the next one."""
        with self._lock:
            behind = self.first + len(self._messages)
            newest = [*islice(reversed(self._messages), behind - number)]
            return newest[::-1], behind

    def hold(self, number: float) -> None:
        """Keep the messages from a number on."""
        with self._lock:
            self._held = number
            self._drop_old()


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
        self._ring = ring
        self._latched, self.next = ring.begin()  # The number of the first message not yet taken.
        self.is_full = False  # True once messages are lost, as too many waited.
        self.flushed = 0.0  # Monotonic time of the last order to write.
        self.is_waiting = False  # True while such an order waits for the writing thread.
        self.failed: float | None = None  # Monotonic time at which writing failed.
        self.writer: BagWriter | None = None
        self.unfinished: Path | None = None  # The folder while nothing of use is in it.

    def extend(self, now: float, why: str) -> None:
        """Prolong it to SECONDS_AFTER from now, but to MAX_SECONDS in all at most."""
        self.ends = min(now + SECONDS_AFTER, self.begun + MAX_SECONDS)
        if why not in self.why:
            self.why.append(why)

    def take_messages(self) -> list[ReceivedMessage]:
        """Return the messages received since the last call."""
        messages, self.next = self._ring.since(self.next)
        latched, self._latched = self._latched, []
        return [*latched, *messages]


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
        now, event = self._clock.monotonic(), self._event
        for recording in (event, self._all):
            if recording is not None:
                recording.is_full = recording.is_full or self.ring.first > recording.next
        if event is not None and (now >= event.ends or event.is_full):
            self._event = None
            self._finish(event)
        if self._all_to is not None:
            self._tick_all(now, self._all_to)
        going = [r.next for r in (self._event, self._all) if r is not None and r.failed is None]
        self.ring.hold(min(going, default=math.inf))

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
            self._all = None
            self._finish(current)
        elif now - current.flushed >= _FLUSH_PERIOD and not current.is_waiting:
            current.flushed, current.is_waiting = now, True
            self._submit(partial(self._write, current, current.take_messages()))

    def _finish(self, recording: _Recording) -> None:
        messages = recording.take_messages()
        if recording.to is None:
            recording.since = _since(self._clock)
            if self._jobs.qsize() > _MAX_WAITING + (self._all_to is not None):
                self._report_failure(recording, _SLOW)
                return
        self._submit(partial(self._write, recording, messages, is_last=True))

    def finish(self) -> None:
        """Hand the recordings that still go on to the writing thread, complete or not."""
        for recording in (self._event, self._all):
            if recording is not None:
                self._finish(recording)
        self._event = self._all = None

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

    def _write(
        self, recording: _Recording, messages: list[ReceivedMessage], *, is_last: bool = False
    ) -> None:
        """Write messages; never raise."""
        recording.is_waiting = False
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
