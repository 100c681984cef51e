"""The curves of the last hour, a sample a second, and the goals that ended. Pure."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from typing import Literal

from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.snapshot import Snapshot

# charge: in %. speed: in the unit of the robot's own messages, m/s in ROS. left: what remains of
# the running goal, in the unit of its feedback.
# x, y: where the robot is, in m.
Quantity = Literal["charge", "speed", "left", "x", "y"]
SPANS = (60.0, 600.0, 3600.0)  # Seconds that a plot may show.
_KEPT = 3600  # Samples, and ended goals.
# Seconds that a sample fills where a column is shorter than a second, so that a tick that comes
# late leaves no gap.
_HOLDS = 1.5


def current_values(snapshot: Snapshot, now: float) -> dict[Quantity, float | None]:
    """Return each quantity at a monotonic time; None if it is old, or not reported now."""
    battery, motion, goal = snapshot.battery, snapshot.motion, snapshot.running_goal
    pose = snapshot.pose._replace(x=None, y=None) if snapshot.pose.is_old(now) else snapshot.pose
    return {
        "charge": None if battery.is_old(now) else battery.percentage,
        "speed": None if motion.is_old(now) else motion.speed,
        "left": None if goal is None else goal.remaining,
        "x": pose.x,
        "y": pose.y,
    }


class History:
    """The samples of the last hour and the last 3600 goals that ended.

    It belongs to the station, so that it survives a crash of the screen. Times are monotonic
    seconds in a console, and Unix time in a replay.
    """

    def __init__(self) -> None:
        self._times = array("d")
        # For each sample the last value, and the least and the greatest since the sample before;
        # NaN if there was none.
        self._last, self._least, self._greatest = _columns(), _columns(), _columns()
        # The least and the greatest value since the last sample.
        self._since: dict[Quantity, tuple[float, float]] = {}
        self._ends: dict[tuple[int, float], Goal] = {}  # By number and time.

    def observe(self, snapshot: Snapshot, now: float) -> None:
        """Widen the range of the next sample by a snapshot, and keep the goals that have ended."""
        for name, value in current_values(snapshot, now).items():
            if value is not None and not math.isnan(value):
                least, greatest = self._since.get(name, (value, value))
                self._since[name] = min(least, value), max(greatest, value)
        for goal in reversed(snapshot.history):
            self._ends.setdefault((goal.number, goal.time), goal)
        while len(self._ends) > _KEPT:
            del self._ends[next(iter(self._ends))]

    def add_sample(self, snapshot: Snapshot, now: float) -> None:
        """Add a sample: the values now, and their range since the last one; keep ended goals."""
        self.observe(snapshot, now)
        self._times.append(now)
        for name, value in current_values(snapshot, now).items():
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
        """Return a copy of the history of a replay with what was known at a Unix time."""
        earlier, count = History(), bisect_right(self._times, now)
        earlier._times = self._times[:count]
        for columns, earlier_columns in (
            (self._last, earlier._last),
            (self._least, earlier._least),
            (self._greatest, earlier._greatest),
        ):
            earlier_columns.update({name: column[:count] for name, column in columns.items()})
        earlier._ends = {key: goal for key, goal in self._ends.items() if goal.time <= now}
        return earlier

    @property
    def begin(self) -> float | None:
        """The time of the first sample that is kept; None if there is none."""
        return self._times[0] if self._times else None

    @property
    def ends(self) -> list[Goal]:
        """The goals that have ended, the newest first."""
        return list(reversed(self._ends.values()))

    def last_values(
        self, quantity: Quantity, span: float, count: int, now: float
    ) -> list[float | None]:
        """Return the last value in each of `count` columns over `span` s, the newest last.

        Columns begin at multiples of their length, so that a past one never changes.
        """
        found: list[float | None] = [None] * count
        for number, filled in self._columns_filled(span, count, now):
            value = self._last[quantity][number]
            for column in filled:
                found[column] = None if math.isnan(value) else value
        return found

    def ranges(
        self, quantity: Quantity, span: float, count: int, now: float
    ) -> list[tuple[float, float] | None]:
        """Return the least and the greatest value in each column, as `last_values` divides them."""
        found: list[tuple[float, float] | None] = [None] * count
        for number, filled in self._columns_filled(span, count, now):
            least, greatest = self._least[quantity][number], self._greatest[quantity][number]
            if math.isnan(least):
                continue
            for column in filled:
                low, high = found[column] or (least, greatest)
                found[column] = min(low, least), max(high, greatest)
        return found

    def _columns_filled(self, span: float, count: int, now: float) -> Iterator[tuple[int, range]]:
        width = span / count
        newest = int(now // width)
        oldest = newest - count + 1
        for number in range(bisect_left(self._times, oldest * width), len(self._times)):
            at = self._times[number]
            until = min(int((at + _HOLDS) // width), newest) if width < 1.0 else 0
            column = max(int(at // width), oldest)  # The product above may have been rounded.
            yield number, range(column - oldest, max(column, until) - oldest + 1)


def _columns() -> dict[Quantity, array[float]]:
    return {name: array("d") for name in current_values(Snapshot(), 0.0)}
