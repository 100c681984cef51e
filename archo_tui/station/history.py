"""What the last hour was like: a sample a second. Pure: snapshots and the time in, columns out."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from typing import Literal

from archo_tui.robot.state import Goal, Snapshot

# charge: %; speed: in the unit of the robot's own messages, m/s in ROS; left: of the goal's way, in
# the unit of its remainder
Quantity = Literal["charge", "speed", "left"]
SPANS = (60.0, 600.0, 3600.0)  # s that can be looked back
_KEPT = 3600  # samples
_HOLDS = 1.5  # s that a sample stands for: where the parts are shorter than a second


def readings(snapshot: Snapshot, now: float) -> dict[Quantity, float | None]:
    """What there is of each quantity; None: not heard, or not reported by this robot."""
    battery, motion, goal = snapshot.battery, snapshot.motion, snapshot.running_goal
    return {
        "charge": None if battery.is_old(now) else battery.percentage,
        "speed": None if motion.is_old(now) else motion.speed,
        "left": None if goal is None else goal.remaining,
    }


class History:
    """Bounded; what was before a screen crashed is still there."""

    def __init__(self) -> None:
        self._times = array("d")  # monotonic s
        # of each sample: the last value, and the least and greatest since the sample before; NaN:
        # there was none
        self._last, self._least, self._greatest = _columns(), _columns(), _columns()
        self._since: dict[Quantity, tuple[float, float]] = {}  # the last sample: least, greatest
        self._ends: dict[tuple[int, float], Goal] = {}  # by number and time

    def take(self, snapshot: Snapshot, now: float) -> None:
        """Note a snapshot, so that nothing between two samples is lost."""
        for name, value in readings(snapshot, now).items():
            if value is not None and not math.isnan(value):
                least, greatest = self._since.get(name, (value, value))
                self._since[name] = min(least, value), max(greatest, value)
        for goal in reversed(snapshot.history):
            self._ends.setdefault((goal.number, goal.time), goal)
        while len(self._ends) > _KEPT:
            del self._ends[next(iter(self._ends))]

    def add(self, snapshot: Snapshot, now: float) -> None:
        """Keep a sample: how it is now, and what was noted since the last sample."""
        self.take(snapshot, now)
        self._times.append(now)
        for name, value in readings(snapshot, now).items():
            least, greatest = self._since.get(name, (math.nan, math.nan))
            self._last[name].append(math.nan if value is None else value)
            self._least[name].append(least)
            self._greatest[name].append(greatest)
        self._since.clear()
        for columns in (self._last, self._least, self._greatest):
            for column in columns.values():
                del column[:-_KEPT]
        del self._times[:-_KEPT]

    def until(self, now: float) -> History:
        """Return the history of a replay as it was at that Unix time."""
        earlier, count = History(), bisect_right(self._times, now)
        earlier._times = self._times[:count]
        for ours, its in (
            (self._last, earlier._last),
            (self._least, earlier._least),
            (self._greatest, earlier._greatest),
        ):
            its.update({name: column[:count] for name, column in ours.items()})
        earlier._ends = {key: goal for key, goal in self._ends.items() if goal.time <= now}
        return earlier

    @property
    def ends(self) -> list[Goal]:
        """The goals that have ended, the newest first."""
        return list(reversed(self._ends.values()))

    def columns(
        self, quantity: Quantity, span: float, count: int, now: float
    ) -> list[float | None]:
        """The last value in each of `count` equal parts of the last `span` s, the newest last.

        The parts begin at multiples of their length: a column never changes once it is past.
        """
        found: list[float | None] = [None] * count
        for number, places in self._places(span, count, now):
            value = self._last[quantity][number]
            for place in places:
                found[place] = None if math.isnan(value) else value
        return found

    def ranges(
        self, quantity: Quantity, span: float, count: int, now: float
    ) -> list[tuple[float, float] | None]:
        """Return the least and the greatest value in each of the parts of `columns`."""
        found: list[tuple[float, float] | None] = [None] * count
        for number, places in self._places(span, count, now):
            least, greatest = self._least[quantity][number], self._greatest[quantity][number]
            if math.isnan(least):
                continue
            for place in places:
                low, high = found[place] or (least, greatest)
                found[place] = min(low, least), max(high, greatest)
        return found

    def _places(self, span: float, count: int, now: float) -> Iterator[tuple[int, range]]:
        """Yield the number of each sample of the last `span` s, and the parts that it is in."""
        part = span / count
        newest = int(now // part)
        first = newest - count + 1
        for number in range(bisect_left(self._times, first * part), len(self._times)):
            at = self._times[number]
            until = min(int((at + _HOLDS) // part), newest) if part < 1.0 else 0
            place = max(int(at // part), first)  # the product above may have been rounded
            yield number, range(place - first, max(place, until) - first + 1)


def _columns() -> dict[Quantity, array[float]]:
    return {name: array("d") for name in readings(Snapshot(), 0.0)}
