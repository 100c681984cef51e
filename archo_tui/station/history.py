"""The curves of the last hour, and the goals that ended. Pure."""

from __future__ import annotations

import math
from typing import Literal

from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.topics.rows import Range, Series

# charge: in %. speed: in the unit of the robot's own messages, m/s in ROS. left: what remains of
# the running goal, in the unit of its feedback.
# x, y: where the robot is, in m.
Quantity = Literal["charge", "speed", "left", "x", "y"]
SPANS = (60.0, 600.0, 3600.0)  # Seconds that a plot may show.
_KEPT = 3600  # Seconds with values, and ended goals.


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
    """The values of the last hour and the last 3600 goals that ended.

    Times are monotonic in a console, and Unix time in a replay.
    """

    def __init__(self) -> None:
        self.begin: float | None = None  # When the first snapshot came; None before it.
        self._series: dict[Quantity, Series] = {
            quantity: Series(1, _KEPT) for quantity in current_values(Snapshot(), 0.0)
        }
        self._ends: dict[tuple[int, float], Goal] = {}  # By number and time.

    def observe(self, snapshot: Snapshot, now: float) -> None:
        """Add a snapshot's values, and keep the goals that have ended; call it each second, too."""
        self.begin = now if self.begin is None else self.begin
        for name, value in current_values(snapshot, now).items():
            if value is not None and not math.isnan(value):
                self._series[name].add(math.floor(now), value)
        for goal in reversed(snapshot.history):
            self._ends.setdefault((goal.number, goal.time), goal)
        while len(self._ends) > _KEPT:
            del self._ends[next(iter(self._ends))]

    def ends(self, time: float) -> list[Goal]:
        """Return the goals that have ended by a Unix time, the newest first."""
        return [goal for goal in reversed(tuple(self._ends.values())) if goal.time <= time]

    def ranges(
        self, quantity: Quantity, span: float, count: int, now: float
    ) -> tuple[Range | None, ...]:
        """Return the least and the greatest value in each of `count` columns; see `Series`."""
        return self._series[quantity].curve(now, span, count)
