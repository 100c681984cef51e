"""What the last hour was like: a sample a second. Pure: snapshots and the time in, columns out."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from typing import Literal

from archo_tui.robot.state import Snapshot

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
        # NaN: none
        self._values = {name: array("d") for name in readings(Snapshot(), 0.0)}

    def add(self, snapshot: Snapshot, now: float) -> None:
        """Keep how it is now."""
        self._times.append(now)
        for name, value in readings(snapshot, now).items():
            self._values[name].append(math.nan if value is None else value)
        for column in (self._times, *self._values.values()):
            del column[:-_KEPT]

    def until(self, now: float) -> History:
        """As it was at that time (monotonic s)."""
        earlier, count = History(), bisect_right(self._times, now)
        earlier._times = self._times[:count]
        earlier._values = {name: column[:count] for name, column in self._values.items()}
        return earlier

    def columns(
        self, quantity: Quantity, span: float, count: int, now: float
    ) -> list[float | None]:
        """The last value in each of `count` equal parts of the last `span` s, the newest last.

        The parts begin at multiples of their length: a column never changes once it is past.
        """
        part = span / count
        newest = int(now // part)
        found: list[float | None] = [None] * count
        first = newest - count + 1
        values = self._values[quantity]
        for number in range(bisect_left(self._times, first * part), len(self._times)):
            at, value = self._times[number], values[number]
            until = min(int((at + _HOLDS) // part), newest) if part < 1.0 else 0
            place = max(int(at // part), first)  # the product above may have been rounded
            for later in range(place, max(place, until) + 1):
                found[later - first] = None if math.isnan(value) else value
        return found
