"""`rclpy.clock`: clocks, simulated time, and what is told when a clock jumps."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable
from enum import Enum
from typing import Any

from rclpy import _time_source
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import NotInitializedException
from rclpy.time import Time
from rclpy.utilities import get_default_context

__all__ = [
    "Clock",
    "ClockChange",
    "ClockType",
    "JumpHandle",
    "JumpThreshold",
    "ROSClock",
    "TimeJump",
]


class ClockChange(Enum):
    """Whether a ROS clock took to simulated time, or left it."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


class JumpThreshold:
    """How far a clock must jump, forward or (negative) backward, for its follower to be told."""

    def __init__(
        self,
        *,
        min_forward: Duration | None,
        min_backward: Duration | None,
        on_clock_change: bool = True,
    ) -> None:
        """Raises ValueError for a span of the wrong sign, and when nothing is followed."""
        if min_forward is not None and min_forward.nanoseconds <= 0:
            raise ValueError("min_forward must be a positive non-zero duration")
        if min_backward is not None and min_backward.nanoseconds >= 0:
            raise ValueError("min_backward must be a negative non-zero duration")
        if min_forward is None and min_backward is None and not on_clock_change:
            raise ValueError("At least one jump threshold must be enabled")
        self.min_forward, self.min_backward = min_forward, min_backward
        self.on_clock_change = on_clock_change

    def _is_passed(self, jump: TimeJump) -> bool:
        if jump.clock_change != ClockChange.ROS_TIME_NO_CHANGE:
            return self.on_clock_change
        far = self.min_forward is not None and jump.delta >= self.min_forward
        return far or (self.min_backward is not None and jump.delta <= self.min_backward)


class TimeJump:
    """What a clock did."""

    def __init__(self, clock_change: ClockChange, delta: Duration) -> None:
        if not isinstance(clock_change, ClockChange):
            raise TypeError("clock_change must be an instance of rclpy.clock.ClockChange")
        self.clock_change = clock_change
        self.delta = delta


class JumpHandle:
    """One follower of a clock's jumps; also a context manager that ends with `unregister()`."""

    def __init__(
        self,
        *,
        clock: Clock,
        threshold: JumpThreshold,
        pre_callback: Callable[[], None] | None,
        post_callback: Callable[[TimeJump], None] | None,
    ) -> None:
        """Raises ValueError without a callback, and for one that cannot be called."""
        if pre_callback is None and post_callback is None:
            raise ValueError("One of pre_callback or post_callback must be callable")
        for name, callback in (("pre", pre_callback), ("post", post_callback)):
            if callback is not None and not callable(callback):
                raise ValueError(f"{name}_callback must be callable if given")
        self._clock: Clock | None = clock
        self._threshold, self._pre, self._post = threshold, pre_callback, post_callback
        clock._followers.append(self)

    def unregister(self) -> None:
        """Be told no more."""
        if self._clock is not None:
            self._clock._followers.remove(self)
            self._clock = None

    def __enter__(self) -> JumpHandle:
        return self

    def __exit__(self, *_: object) -> None:
        self.unregister()


class Clock:
    """Tells the time of one kind of clock."""

    def __new__(cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> Clock:
        """A ROSClock for ROS_TIME. Raises TypeError for no ClockType."""
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        return super().__new__(ROSClock if clock_type == ClockType.ROS_TIME else cls)

    def __init__(self, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> None:
        self._clock_type = clock_type
        self._followers: list[JumpHandle] = []
        self._changed = threading.Condition()  # of simulated time

    def __repr__(self) -> str:
        return f"Clock(clock_type={self._clock_type.name})"

    @property
    def clock_type(self) -> ClockType:
        """The kind of clock this is."""
        return self._clock_type

    @property
    def _is_simulated(self) -> bool:
        return False

    def now(self) -> Time:
        """The time now: monotonic for STEADY_TIME, else since the Unix epoch."""
        steady = self._clock_type == ClockType.STEADY_TIME
        now = _time_source.monotonic_ns() if steady else _time_source.time_ns()
        return Time(nanoseconds=now, clock_type=self._clock_type)

    def create_jump_callback(
        self,
        threshold: JumpThreshold,
        *,
        pre_callback: Callable[[], None] | None = None,
        post_callback: Callable[[TimeJump], None] | None = None,
    ) -> JumpHandle:
        """Have callbacks called before and after each jump beyond a threshold."""
        return JumpHandle(
            clock=self, threshold=threshold, pre_callback=pre_callback, post_callback=post_callback
        )

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Block until that time on this clock.

        False when the context was shut down before, or simulated time began or ended.
        Raises ValueError for another kind of clock, NotInitializedException after shutdown.
        """
        context = get_default_context() if context is None else context
        if not context.ok():
            raise NotInitializedException
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        over = _Over(self._changed)
        context.on_shutdown(over.wake)
        simulated = self._is_simulated
        left = until.nanoseconds - self.now().nanoseconds
        end = None if simulated else _time_source.monotonic_ns() + left
        with self._changed:
            _time_source.wait_until(
                self._changed,
                lambda: (
                    not context.ok()
                    or self._is_simulated != simulated
                    or (simulated and self.now().nanoseconds >= until.nanoseconds)
                ),
                end,
            )
        return context.ok() and self._is_simulated == simulated

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Block for that long on this clock; see `sleep_until`."""
        return self.sleep_until(self.now() + rel_time, context)


class _Over:
    """What the shutdown of a context wakes."""

    def __init__(self, condition: threading.Condition) -> None:
        self._condition = condition

    def wake(self) -> None:
        with self._condition:
            self._condition.notify_all()


class ROSClock(Clock):
    """The clock of a node: the system's, or simulated time while that is active."""

    def __new__(cls, **_: Any) -> ROSClock:
        return object.__new__(cls)

    def __init__(self, **_: Any) -> None:
        super().__init__(clock_type=ClockType.ROS_TIME)
        self._override_ns = 0
        self._is_active = False
        self._timers: weakref.WeakSet[Any] = weakref.WeakSet()

    @property
    def ros_time_is_active(self) -> bool:
        """True while the time is simulated."""
        return self._is_active

    @property
    def _is_simulated(self) -> bool:
        return self._is_active

    def now(self) -> Time:
        if self._is_active:
            return Time(nanoseconds=self._override_ns, clock_type=self._clock_type)
        return super().now()

    def _set_ros_time_is_active(self, enabled: bool) -> None:
        if enabled == self._is_active:
            return
        before = self._timer_ns()
        to = ClockChange.ROS_TIME_ACTIVATED if enabled else ClockChange.ROS_TIME_DEACTIVATED
        self._jump(to, self._override_ns, enabled)
        for timer in list(self._timers):
            timer._change_time(simulated=enabled, until_ns=before)

    def set_ros_time_override(self, time: Time) -> None:
        """The simulated time is this now. Raises TypeError for anything but a Time."""
        if not isinstance(time, Time):
            raise TypeError(
                f"Time must be specified as rclpy.time.Time. Received type: {type(time)}"
            )
        if not self._is_active:
            self._override_ns = time.nanoseconds
            return
        self._jump(ClockChange.ROS_TIME_NO_CHANGE, time.nanoseconds, True)
        for timer in list(self._timers):
            timer._look()

    def _timer_ns(self) -> int:
        """What timers of this clock count."""
        return self._override_ns if self._is_active else _time_source.monotonic_ns()

    def _jump(self, change: ClockChange, override_ns: int, active: bool) -> None:
        """Take another time, tell the followers before and after, wake those who sleep."""
        goes_on = change == ClockChange.ROS_TIME_NO_CHANGE
        delta = override_ns - self._override_ns if goes_on else 0  # between two times there is none
        jump = TimeJump(change, Duration(nanoseconds=delta))
        told = [handle for handle in self._followers if handle._threshold._is_passed(jump)]
        for handle in told:
            if handle._pre is not None:
                handle._pre()
        self._override_ns, self._is_active = override_ns, active
        for handle in told:
            if handle._post is not None:
                handle._post(jump)
        with self._changed:
            self._changed.notify_all()
