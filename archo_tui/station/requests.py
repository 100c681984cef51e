"""What assistants ask for: none of it is done before a person at this console allows it. Pure."""

from __future__ import annotations

from asyncio import Future
from collections.abc import Iterator
from enum import Enum
from typing import Any, NamedTuple

from archo_tui.robot.asker import Asker
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import Goal
from archo_tui.robot.values import text_of
from archo_tui.station.queue import QueuedGoal
from archo_tui.yaml_text.dump import flow

MOST = 3  # that wait at a time
EXPIRES = 60.0  # s after which nobody has answered
PAUSE = 10.0  # s after a no in which nothing is asked: what it hides is seen
READ = 1.0  # s that a request is shown before an answer counts: as long as it takes to read
_KEPT = 100  # that are over


def written(value: Any) -> str:
    """A value as it is shown; a text is in quotes: nothing in it looks like the next value."""
    return flow(value) if isinstance(value, str) else text_of(value)


class Stand(Enum):
    """Where a request stands; the value is the word for it."""

    WAITS = "waits for a person"
    ALLOWED = "allowed"
    DENIED = "denied"
    EXPIRED = "expired"
    VOID = "void"


class Request(NamedTuple):
    """One goal that an assistant wants; allowed once, and for exactly these values."""

    number: int
    asker: Asker
    goal: QueuedGoal
    text: str  # `go to shelf 12`
    made: float  # monotonic s
    stops: int  # that were known of then, here and at other consoles
    stand: Stand = Stand.WAITS
    why: str = ""  # it is void
    end: Future[Outcome] | None = None  # how the goal ends, once it is allowed
    ended: Goal | None = None  # the goal, then

    def left(self, now: float) -> float:
        """Seconds until it expires."""
        return max(self.made + EXPIRES - now, 0.0)


class Requests:
    """Those that wait, and the last ones that were answered."""

    def __init__(self) -> None:
        self._all: dict[int, Request] = {}
        self._last = 0
        self._denied = -PAUSE  # when the last one was, monotonic s

    @property
    def waiting(self) -> tuple[Request, ...]:
        """The oldest first."""
        return tuple(one for one in self._all.values() if one.stand == Stand.WAITS)

    def get(self, number: int) -> Request | None:
        """The request of that number."""
        return self._all.get(number)

    def add(self, asker: Asker, goal: QueuedGoal, text: str, now: float, stops: int) -> Request:
        """A new one. Raises ValueError when too many wait, or a person has just said no."""
        again = self._denied + PAUSE - now
        if again > 0:
            raise ValueError(f"a person has just said no: wait {again:.0f} s")
        if len(self.waiting) >= MOST:
            raise ValueError(f"{MOST} requests wait for a person already")
        self._last += 1
        made = self._all[self._last] = Request(self._last, asker, goal, text, now, stops)
        for number in [one.number for one in self._all.values() if one.stand != Stand.WAITS]:
            if len(self._all) > _KEPT:
                del self._all[number]
        return made

    def end(self, number: int, stand: Stand, why: str = "") -> Request:
        """It is answered, or over."""
        self._all[number] = ended = self._all[number]._replace(stand=stand, why=why)
        return ended

    def deny(self, number: int, now: float) -> None:
        """A person said no."""
        self.end(number, Stand.DENIED)
        self._denied = now

    def goal_ended(self, end: Future[Outcome] | None, goal: Goal) -> None:
        """The goal of a request, if it is one's."""
        for one in self._all.values():
            if end is not None and one.end is end:
                self._all[one.number] = one._replace(ended=goal)
                return

    def drives(self, number: int, end: Future[Outcome]) -> None:
        """What was allowed has been sent."""
        self._all[number] = self._all[number]._replace(end=end)

    def look(self, now: float, stops: int, busy: str) -> list[Request]:
        """End those whose time is over; `busy` says what else the robot does. Returns them."""
        return [*self._over(now, stops, busy)]

    def _over(self, now: float, stops: int, busy: str) -> Iterator[Request]:
        for one in self.waiting:
            if one.stops != stops:
                yield self.end(one.number, Stand.VOID, "a STOP came")
            elif one.asker.has_left:
                yield self.end(one.number, Stand.VOID, "the assistant has left")
            elif busy:
                yield self.end(one.number, Stand.VOID, busy)
            elif now - one.made >= EXPIRES:
                yield self.end(one.number, Stand.EXPIRED, f"nobody answered in {EXPIRES:g} s")
