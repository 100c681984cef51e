"""The last STOP is final: a request that was typed before it, and has not left yet, is not sent.

Each input of a person carries the number of STOPs that had been read when it was read. That number
is compared at the last moment, as the request leaves for the robot, however long it waited before.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple

from archo_tui.robot.messages.typed import typed_request
from archo_tui.robot_file.model import StopServices

# Why a request was not sent.
NOT_SENT = "not sent: STOP came after it"
NEVER_LEFT = "cancelled before it was sent"
HELD = "held: STOP"  # A queued goal: the robot is stopped, or is about to be.
OPEN_STOP = "the STOP is not confirmed: release it first, or give it up"
UNCERTAIN = "the STOP is no longer certain: release it, or stop again"
HOLDS = "the robot is stopped: release it first"

MIN_INTERVAL = 1.0  # Seconds in which at most two STOPs leave, if nothing else is requested.
_HELP = ["--help"]


class Void(Exception):
    """The error of a request that is not sent: a STOP came after its input, here or elsewhere."""


class Stops:
    """A counter of the STOPs that were read. Any thread may use it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._stop: StopServices | None = None
        self._service_names: frozenset[str] = frozenset()
        self.count = 0  # STOPs that this console has read, whoever typed them.
        self.answered = 0  # Up to this `count` all were answered, or are not awaited any more.
        self.sent_elsewhere = 0  # Reports of STOPs by other consoles, whatever came of them.
        # True if another verb was requested, by any console, since a STOP began to be sent here.
        self.superseded = False
        self._typed_at: ContextVar[int | None] = ContextVar("stops", default=None)
        # Of the others' reports, where they are to be compared with those of an earlier moment.
        self._reported_at: ContextVar[int | None] = ContextVar("reports", default=None)

    def set_service(self, stop: StopServices, full_name: str) -> None:
        """Set the robot's STOP, whose service `is_stop_call` recognizes by both names."""
        self._stop = stop
        self._service_names = frozenset((stop.service, full_name, full_name.lstrip("/")))

    def is_stop_call(self, words: Sequence[str]) -> bool:
        """Return True if the words are `call` with the STOP's own service: a STOP that is typed so.

        If the robot file names values for its request, exactly these must be typed: other
        values may be the release. If not, any words behind the service do, except `--help`;
        `--yes` is ignored.
        """
        verb, *rest = [word for word in words if word != "--yes"] or [""]
        if verb != "call" or not rest or rest[0] not in self._service_names or self._stop is None:
            return False
        request = self._stop.request
        if not request:
            return rest[1:] != _HELP
        try:
            return typed_request(rest[0], rest[1:], request) == request
        except ValueError:
            return False

    def register(self) -> int:
        """Count a STOP that was just read; requests that were read before leave no more."""
        with self._lock:
            self.count += 1
            return self.count

    def is_not_sent(self, number: int) -> None:
        """Record that the STOP with this `count` is not sent: one before it answers for it."""
        with self._lock:
            if self.answered >= number - 1:
                self.answered = max(self.answered, number)

    @property
    def are_answered(self) -> bool:
        """True if no STOP that this console read is still to be sent, or waits for its answers."""
        return self.answered >= self.count

    @property
    def total(self) -> int:
        """The STOPs that were read here, and the reports of those of other consoles."""
        return self.count + self.sent_elsewhere

    @property
    def total_when_typed(self) -> int:
        """The `count_when_typed`, with the reports of other consoles by now."""
        return self.count_when_typed + self.sent_elsewhere

    @property
    def count_when_typed(self) -> int:
        """The value of `count` when the present input was read; the present `count` if not set."""
        typed_at = self._typed_at.get()
        return self.count if typed_at is None else typed_at

    @contextmanager
    def typed_at(self, count: int | None, reported: int | None = None) -> Iterator[None]:
        """Set the count at which the present input was read, for the `with` block.

        `reported` is what `sent_elsewhere` was then; None: as it is now.
        """
        before, reports_before = self._typed_at.set(count), self._reported_at.set(reported)
        try:
            yield
        finally:
            self._typed_at.reset(before)
            self._reported_at.reset(reports_before)

    def set_typed_at(self, count: int | None) -> None:
        """Set the count at which the present input was read; None for work without input."""
        self._typed_at.set(count)

    def is_void(self, count: int) -> bool:
        """Return True if a STOP was read after the input that was read at `count`."""
        return count < self.count

    def gate(self) -> Gate:
        """Return the last check for a request that the present input causes."""
        reported = self._reported_at.get()
        elsewhere = self.sent_elsewhere if reported is None else reported
        return Gate(self, self.count_when_typed, elsewhere)


class Gate(NamedTuple):
    """The last check before a request is sent: refuses it if a STOP came in the meantime."""

    stops: Stops  # Compared with these counts of when the input was read.
    count_when_typed: int
    sent_elsewhere: int

    @property
    def is_shut(self) -> bool:
        """True if a STOP was read after the input, or another console has reported one since."""
        is_stopped_elsewhere = self.stops.sent_elsewhere > self.sent_elsewhere
        return self.stops.is_void(self.count_when_typed) or is_stopped_elsewhere

    def __call__(self) -> None:
        """Raise Void if the gate is shut; called just before the request is sent."""
        if self.is_shut:
            raise Void


class RateLimit:
    """A limit of two STOPs a second, for STOPs with nothing else requested between them."""

    def __init__(self) -> None:
        self._sent = deque([-MIN_INTERVAL] * 2, maxlen=2)  # Monotonic seconds of the last two.

    def delay(self, now: float) -> float:
        """Return the seconds until the next STOP may leave; zero or less for at once."""
        return self._sent[0] + MIN_INTERVAL - now

    def record(self, now: float) -> None:
        """Record that a STOP leaves at `now`, in monotonic seconds."""
        self._sent.append(now)
