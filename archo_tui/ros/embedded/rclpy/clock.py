"""The module `rclpy.clock`: clocks and simulated time."""

from __future__ import annotations

import threading
import weakref
from typing import Any

from rclpy import _time_source
from rclpy.clock_type import ClockType as ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import NotInitializedException
from rclpy.time import Time
from rclpy.utilities import get_default_context


class Clock:
    """A clock of one kind; `Clock(clock_type=ClockType.ROS_TIME)` makes a ROSClock."""

    def __new__(cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> Clock:
        """Create a clock, a ROSClock for ROS_TIME; raise TypeError for no ClockType."""
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        return super().__new__(ROSClock if clock_type == ClockType.ROS_TIME else cls)

    def __init__(self, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> None:
        self._clock_type = clock_type
        self.ros_time_is_active = False  # Simulated time; True for a ROSClock only.
        self._changed = threading.Condition()  # Notified when simulated time changes.

    def __repr__(self) -> str:
        return f"Clock(clock_type={self._clock_type.name})"

    @property
    def clock_type(self) -> ClockType:
        """Return the kind of clock this is."""
        return self._clock_type

    def now(self) -> Time:
        """Return the time now: monotonic for STEADY_TIME, simulated if active, else Unix time."""
        steady = self._clock_type == ClockType.STEADY_TIME
        now = _time_source.monotonic_ns() if steady else _time_source.time_ns()
        return Time(nanoseconds=now, clock_type=self._clock_type)

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Block until that time on this clock; a time that has passed returns True at once."""
        context = get_default_context() if context is None else context
        if not context.ok():
            raise NotInitializedException
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        context.on_shutdown(self._wake)
        simulated = self.ros_time_is_active
        left = until.nanoseconds - self.now().nanoseconds
        end = None if simulated else _time_source.monotonic_ns() + left
        with self._changed:
            _time_source.wait_until(
                self._changed,
                lambda: (
                    not context.ok()
                    or self.ros_time_is_active != simulated
                    or (simulated and self.now().nanoseconds >= until.nanoseconds)
                ),
                end,
            )
        return context.ok() and self.ros_time_is_active == simulated

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Block for that long on this clock; results and errors are those of `sleep_until`."""
        return self.sleep_until(self.now() + rel_time, context)

    def _wake(self) -> None:
        with self._changed:
            self._changed.notify_all()


class ROSClock(Clock):
    """The clock of a node: Unix time, or simulated time while that is active.

    Every ROSClock has its own simulated time.
    """

    def __new__(cls, **_: Any) -> ROSClock:
        return object.__new__(cls)

    def __init__(self, **_: Any) -> None:
        super().__init__(clock_type=ClockType.ROS_TIME)
        self._override_ns = 0
        self._timers: weakref.WeakSet[Any] = weakref.WeakSet()

    def now(self) -> Time:
        if self.ros_time_is_active:
            return Time(nanoseconds=self._override_ns, clock_type=self._clock_type)
        return super().now()

    def _set_ros_time_is_active(self, enabled: bool) -> None:
        if enabled == self.ros_time_is_active:
            return
        before = self._timer_ns()
        self._take(self._override_ns, enabled)
        for timer in list(self._timers):
            timer._change_time(simulated=enabled, until_ns=before)

    def set_ros_time_override(self, time: Time) -> None:
        """Set the simulated time; while that is active, make due timers ready and wake sleepers.

        While simulated time is not active, the time is only kept.
        """
        if not self.ros_time_is_active:
            self._override_ns = time.nanoseconds
            return
        self._take(time.nanoseconds, True)
        for timer in list(self._timers):
            timer._announce_if_due()

    def _timer_ns(self) -> int:
        """Return the time that timers of this clock count, in ns: simulated, or else monotonic."""
        return self._override_ns if self.ros_time_is_active else _time_source.monotonic_ns()

    def _take(self, override_ns: int, active: bool) -> None:
        """Set the simulated time and whether it is active, and wake all sleepers."""
        self._override_ns, self.ros_time_is_active = override_ns, active
        self._wake()
