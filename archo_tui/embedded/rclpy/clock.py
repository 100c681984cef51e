"""`rclpy.clock.Clock`. ROS time is system time here: the engine has no simulated time."""

from __future__ import annotations

from rclpy import _time_source
from rclpy.clock_type import ClockType
from rclpy.time import Time

__all__ = ["Clock", "ClockType", "ROSClock"]


class Clock:
    """Tells the time of one kind of clock."""

    def __init__(self, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> None:
        self._clock_type = clock_type

    @property
    def clock_type(self) -> ClockType:
        """The kind of clock this is."""
        return self._clock_type

    def now(self) -> Time:
        """The time now: monotonic for STEADY_TIME, else since the Unix epoch."""
        steady = self._clock_type == ClockType.STEADY_TIME
        now = _time_source.monotonic_ns() if steady else _time_source.time_ns()
        return Time(nanoseconds=now, clock_type=self._clock_type)


class ROSClock(Clock):
    """The clock of a node."""

    def __init__(self) -> None:
        super().__init__(clock_type=ClockType.ROS_TIME)
