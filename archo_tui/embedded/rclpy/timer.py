"""`rclpy.timer.Timer`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy import _time_source
from rclpy._entity import Entity
from rclpy._rclpy_pybind11 import RCLError
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock
from rclpy.context import Context
from rclpy.exceptions import ROSInterruptException

if TYPE_CHECKING:
    from rclpy.node import Node


class Timer(Entity):
    """Calls back once a period, first after one period. Late ticks are skipped, never queued.

    Made by `Node.create_timer`. Runs on monotonic time.
    """

    def __init__(
        self,
        node: Node,
        callback: Callable[[], Any],
        callback_group: CallbackGroup,
        period_ns: int,
        clock: Clock,
    ) -> None:
        super().__init__(node, callback_group)
        if period_ns < 0:
            raise RCLError("failed to create timer: timer period must be non-negative")
        self.callback = callback
        self.clock = clock
        self._period_ns = period_ns
        self._canceled = False
        self._last_ns = _time_source.monotonic_ns()
        self._next_ns = self._last_ns + period_ns

    @property
    def timer_period_ns(self) -> int:
        """The period in ns; a new one counts from the next call on (or from `reset()`)."""
        return self._period_ns

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        self._period_ns = int(value)

    def is_ready(self) -> bool:
        """True when the callback is due."""
        return not self._canceled and _time_source.monotonic_ns() >= self._next_ns

    def is_canceled(self) -> bool:
        """True between `cancel()` and `reset()`."""
        return self._canceled

    def cancel(self) -> None:
        """Stop ticking until `reset()`."""
        self._canceled = True

    def reset(self) -> None:
        """Tick (again), a full period from now."""
        self._canceled = False
        self._next_ns = _time_source.monotonic_ns() + self._period_ns
        self._schedule()

    def time_since_last_call(self) -> int:
        """ns since the callback was last called (or the timer made)."""
        return _time_source.monotonic_ns() - self._last_ns

    def time_until_next_call(self) -> int | None:
        """ns until the callback is due, negative when late, None when canceled."""
        return None if self._canceled else self._next_ns - _time_source.monotonic_ns()

    def destroy(self) -> None:
        """Never tick again."""
        self._destroyed = self._canceled = True

    def _schedule(self) -> None:
        executor = self._node.executor
        if executor is not None and not self._canceled:
            executor._add_timer(self)

    def _take(self) -> Callable[[], Any] | None:
        now = _time_source.monotonic_ns()
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
        return self.callback


class Rate:
    """Sleeps at a fixed rate. Made by `Node.create_rate`; another thread must spin the node."""

    def __init__(self, timer: Timer, *, context: Context) -> None:
        self._timer, self._context = timer, context
        self._ticked = threading.Condition()
        self._ticks = 0
        self._is_destroyed = False
        timer.callback = self._tick
        context.on_shutdown(self.destroy)

    def destroy(self) -> None:
        """Let go of those that sleep."""
        with self._ticked:
            self._is_destroyed = True
            self._ticked.notify_all()

    def sleep(self) -> None:
        """Block until the next tick. Raises ROSInterruptException after shutdown."""
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
