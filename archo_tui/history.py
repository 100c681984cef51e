"""What the last hour was like: a sample a second. Pure: snapshots and the time in, columns out."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Callable
from itertools import islice
from typing import NamedTuple

from archo_tui.robot.state import Snapshot

SPANS = (60.0, 600.0, 3600.0)  # s that can be looked back
_KEPT = 3600  # samples
_HOLDS = 1.5  # s that a sample stands for: where the parts are shorter than a second


class Sample(NamedTuple):
    """One second; None: not heard, or not reported by this robot."""

    at: float  # monotonic s
    charge: float | None  # %
    speed: float | None  # in the unit of the robot's own messages, m/s in ROS
    left: float | None  # of the goal's way, in the unit of its remainder


class History:
    """Bounded; what was before a screen crashed is still there."""

    def __init__(self) -> None:
        self._samples: deque[Sample] = deque(maxlen=_KEPT)

    def add(self, snapshot: Snapshot, now: float) -> None:
        """Keep how it is now."""
        battery, motion, goal = snapshot.battery, snapshot.motion, snapshot.goal
        runs = goal is not None and goal.is_running
        self._samples.append(
            Sample(
                now,
                None if battery.is_old(now) else battery.percentage,
                None if motion.is_old(now) else motion.speed,
                goal.remaining if goal is not None and runs else None,
            )
        )

    def columns(
        self, reading: Callable[[Sample], float | None], span: float, count: int, now: float
    ) -> list[float | None]:
        """The last value in each of `count` equal parts of the last `span` s, the newest last.

        The parts begin at multiples of their length: a column never changes once it is past.
        """
        part = span / count
        newest = int(now // part)
        found: list[float | None] = [None] * count
        first = newest - count + 1
        begin = bisect_left(self._samples, first * part, key=lambda s: s.at)
        for sample in islice(self._samples, begin, None):
            until = min(int((sample.at + _HOLDS) // part), newest) if part < 1.0 else 0
            place = max(int(sample.at // part), first)  # the product above may have been rounded
            for later in range(place, max(place, until) + 1):
                found[later - first] = reading(sample)
        return found
