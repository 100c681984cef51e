"""The last STOP is final: what was typed before it, and has not left yet, is not sent.

Whatever is read from a person carries the count of the STOPs that had been read by then. The count
is compared last, where a request leaves for the robot, whatever it waited for before.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple

from archo_tui.robot.typed_request import typed_request
from archo_tui.robot_file.model import StopServices

NOT_SENT = "not sent: STOP came after it"
NEVER_LEFT = "cancelled before it was sent"
APART = 1.0  # s between a STOP and the next but one, when they are all that is asked for
UNCONFIRMED = "the STOP is not confirmed: release it first, or give it up"
UNCERTAIN = "the STOP is no longer certain: release it, or stop again"
HOLDS = "the robot is stopped: release it first"
_HELP = ["--help"]
HELD = "held: STOP"  # of the queue: the robot is stopped, or is to be


class Void(Exception):
    """A STOP was read after what this request came from."""


class Stops:
    """Counts the STOPs that were read. Any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._stop: StopServices | None = None
        self._services: frozenset[str] = frozenset()  # names of the STOP's service
        self.count = 0
        self.answered = 0  # of these, when the answer to the last one came, or did not in time
        self.elsewhere = 0  # that other consoles told of
        self.overtaken = False  # something else was asked for since the last one left
        self._carried: ContextVar[int | None] = ContextVar("stops", default=None)

    def known_as(self, stop: StopServices, full: str) -> None:
        """Set the robot's STOP, and the name that its service has on the graph."""
        self._stop = stop
        self._services = frozenset((stop.service, full, full.lstrip("/")))

    def is_call(self, words: Sequence[str]) -> bool:
        """Return True for `call SERVICE` of the STOP's own service: it is a STOP, too.

        Whatever stands behind the service, but for exactly `--help`, which explains; of a STOP
        that has a request, exactly that: with another one the service may release.
        """
        verb, *rest = [word for word in words if word != "--yes"] or [""]
        if verb != "call" or not rest or rest[0] not in self._services or self._stop is None:
            return False
        request = self._stop.request
        if not request:
            return rest[1:] != _HELP
        try:
            return typed_request(rest[0], rest[1:], request) == request
        except ValueError:
            return False

    def read(self) -> int:
        """A STOP was read, whoever will carry it out; returns its number."""
        with self._lock:
            self.count += 1
            return self.count

    @property
    def are_answered(self) -> bool:
        """True when none is on its way to the robot."""
        return self.answered >= self.count

    @property
    def carried(self) -> int:
        """How many STOPs had been read when what is being done was; of what nobody typed, now."""
        carried = self._carried.get()
        return self.count if carried is None else carried

    @contextmanager
    def at(self, count: int | None) -> Iterator[None]:
        """Do what was read at that count; the tasks that begin here carry it, too."""
        before = self._carried.set(count)
        try:
            yield
        finally:
            self._carried.reset(before)

    def set(self, count: int | None) -> None:
        """As `at`, until it is set again."""
        self._carried.set(count)

    def is_void(self, count: int) -> bool:
        """True for what was read before the last STOP."""
        return count < self.count

    def gate(self) -> Gate:
        """For a request that comes from what is being done."""
        return Gate(self, self.carried, self.elsewhere)


class Gate(NamedTuple):
    """What a request passes as it leaves."""

    stops: Stops
    typed: int  # how many STOPs had been read before what it comes from
    told: int  # how many other consoles had told of

    @property
    def is_shut(self) -> bool:
        """True when a STOP was read since, or another console told of one."""
        return self.stops.is_void(self.typed) or self.stops.elsewhere > self.told

    def __call__(self) -> None:
        """Raises Void when it is shut."""
        if self.is_shut:
            raise Void


class Spared:
    """Of a flood of STOPs two a second reach the robot, unless something else left meanwhile."""

    def __init__(self) -> None:
        self._left = deque([-APART] * 2, maxlen=2)  # when the last two did, monotonic s

    def rest(self, now: float) -> float:
        """How long the next one is to wait, in s, while nothing has `overtaken` the last."""
        return self._left[0] + APART - now

    def leaves(self, now: float) -> None:
        """One is sent."""
        self._left.append(now)
