"""The module `rclpy.timer`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy import _time_source
from rclpy._entity import Entity
from rclpy._rclpy_pybind11 import RCLError
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ROSClock
from rclpy.context import Context
from rclpy.exceptions import ROSInterruptException

if TYPE_CHECKING:
    from rclpy.node import Node


class Timer(Entity):
    """A timer, made by `Node.create_timer`; it calls back once a period, first after a full one.

    Late ticks are skipped, never queued. The timer counts monotonic time, or simulated time while
    its clock tells that. After `destroy()` all other methods raise InvalidHandle.
    """

    def __init__(
        self,
        node: Node,
        callback: Callable[..., Any],
        callback_group: CallbackGroup,
        period_ns: int,
        clock: Clock,
    ) -> None:
        super().__init__(node, callback_group)
        if period_ns < 0:
            raise RCLError("failed to create timer: timer period must be non-negative")
        self.callback: Callable[..., Any] | None = callback
        self._clock = clock
        self._ros_clock = clock if isinstance(clock, ROSClock) else None
        if self._ros_clock is not None:
            self._ros_clock._timers.add(self)
        self._period_ns = period_ns
        self._canceled = False
        self._last_ns = self._now_ns()
        self._next_ns = self._last_ns + period_ns

    @property
    def clock(self) -> Clock:
        """Return the clock whose time is counted."""
        return self._clock

    @property
    def timer_period_ns(self) -> int:
        """Return the period in ns; a new one counts from the next call on, or from `reset()`."""
        self._use()
        return self._period_ns

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        self._use()
        self._period_ns = int(value)

    def is_ready(self) -> bool:
        """Return True if the callback is due and the timer is not canceled."""
        self._use()
        return self._is_due()

    def is_canceled(self) -> bool:
        """Return True between `cancel()` and `reset()`; without autostart, also before."""
        self._use()
        return self._canceled

    def cancel(self) -> None:
        """Stop ticking until `reset()`."""
        self._use()
        self._canceled = True

    def reset(self) -> None:
        """Start or start again: the callback is due a full period from now."""
        self._use()
        self._canceled = False
        self._next_ns = self._now_ns() + self._period_ns
        self._schedule()

    def time_since_last_call(self) -> int:
        """Return the ns since the callback was last called; before that, since creation."""
        self._use()
        return self._now_ns() - self._last_ns

    def time_until_next_call(self) -> int | None:
        """Return the ns until the callback is due, negative if late, None if canceled."""
        self._use()
        return None if self._canceled else self._next_ns - self._now_ns()

    def destroy(self) -> None:
        """End the ticking for good; the node lists the timer until `destroy_timer`."""
        self._destroyed = self._canceled = True

    def _is_due(self) -> bool:
        return not self._canceled and self._now_ns() >= self._next_ns

    def _now_ns(self) -> int:
        clock = self._ros_clock
        return _time_source.monotonic_ns() if clock is None else clock._timer_ns()

    def _schedule(self) -> None:
        """Let the node's executor, if there is one, check the timer when it is next due."""
        executor = self._node.executor
        if executor is None or self._canceled:
            return
        if self._ros_clock is not None and self._ros_clock.ros_time_is_active:
            if self._is_due():
                self._notify()
        else:
            executor._add_timer(self)

    def _announce_if_due(self) -> None:
        """Tell the executor if the new simulated time makes the timer due.

        After a jump backward a full period is waited for.
        """
        if self._now_ns() < self._last_ns:
            self._last_ns = self._now_ns()
            self._next_ns = self._last_ns + self._period_ns
        if self._is_due():
            self._notify()

    def _change_time(self, *, simulated: bool, until_ns: int) -> None:
        """Count simulated time instead of monotonic time from now on, or the other way round.

        Simulated time is usually behind: the next message of /clock then begins a period. When it
        ends, what was left of the period counts as passed, and what had passed as left, as in rcl.
        """
        if simulated:
            shift_ns = _time_source.time_ns() - _time_source.monotonic_ns()
            self._last_ns += shift_ns
            self._next_ns += shift_ns
        else:
            self._last_ns = self._now_ns() - (self._next_ns - until_ns)
            self._next_ns = self._last_ns + self._period_ns
            self._schedule()

    def _take(self) -> Callable[[], Any] | None:
        now = self._now_ns()
        if self._canceled or now < self._next_ns:
            return None
        self._last_ns = now
        self._next_ns += self._period_ns
        if self._next_ns < now and self._period_ns:
            missed = (now - self._next_ns) // self._period_ns + 1
            self._next_ns += missed * self._period_ns
        elif not self._period_ns:
            self._next_ns = now
        self._schedule()
        if self.callback is None:  # As `self.tick()` gives; rclpy fails by its own variable's name.
            raise UnboundLocalError("local variable 'arg_name' is not associated with a value")
        return self.callback


class Rate:
    """A sleeper at a fixed rate, made by `Node.create_rate`; another thread must spin the node.

    The shutdown of the context destroys the rate.
    """

    def __init__(self, timer: Timer, *, context: Context) -> None:
        self._timer, self._context = timer, context
        self._ticked = threading.Condition()
        self._ticks = 0
        self._is_destroyed = False
        timer.callback = self._tick
        context.on_shutdown(self.destroy)

    def destroy(self) -> None:
        """Wake all sleepers, and let every later `sleep()` raise."""
        with self._ticked:
            self._is_destroyed = True
            self._ticked.notify_all()

    def sleep(self) -> None:
        """Block until the next tick, or until the rate is destroyed."""
        if self._is_destroyed and self._context.ok():
            raise RuntimeError("Rate cannot sleep because it has been destroyed")
        with self._ticked:
            seen = self._ticks
            _time_source.wait_until(
                self._ticked, lambda: self._ticks > seen or self._is_destroyed, None
            )
        if not self._context.ok():
            raise ROSInterruptException

    def _tick(self) -> None:
        with self._ticked:
            self._ticks += 1
            self._ticked.notify_all()
