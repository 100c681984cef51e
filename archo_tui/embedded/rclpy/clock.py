"""`rclpy.clock.Clock`. ROS time is system time here: the engine has no simulated time."""

from __future__ import annotations

import threading

from rclpy import _time_source
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import NotInitializedException
from rclpy.time import Time
from rclpy.utilities import get_default_context

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

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Block until that time on this clock; False when the context was shut down before.

        Raises ValueError for another kind of clock, NotInitializedException after shutdown.
        """
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        return self.sleep_for(until - self.now(), context)

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Block for that long; see `sleep_until`."""
        context = get_default_context() if context is None else context
        if not context.ok():
            raise NotInitializedException
        over = _Over()
        context.on_shutdown(over.wake)
        end = _time_source.monotonic_ns() + rel_time.nanoseconds
        with over.condition:
            _time_source.wait_until(over.condition, lambda: not context.ok(), end)
        return context.ok()


class _Over:
    """What the shutdown of a context wakes."""

    def __init__(self) -> None:
        self.condition = threading.Condition()

    def wake(self) -> None:
        with self.condition:
            self.condition.notify_all()


class ROSClock(Clock):
    """The clock of a node."""

    def __init__(self) -> None:
        super().__init__(clock_type=ClockType.ROS_TIME)
