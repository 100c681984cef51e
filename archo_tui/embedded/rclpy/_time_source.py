"""Where the engine takes its time from: one object, so that a test can put its own in its place.

Timers, clocks and the timeouts of every spin and call ask it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol


class TimeSource(Protocol):
    """What the engine asks."""

    def monotonic_ns(self) -> int:
        """ns that only grow."""

    def time_ns(self) -> int:
        """ns since the Unix epoch."""

    def wait(
        self,
        condition: threading.Condition,
        idle: Callable[[], bool],
        until_ns: int | None = None,
    ) -> None:
        """Let go of `condition`, which the caller holds, until it is notified.

        Returns at `until_ns` (of `monotonic_ns`) at the latest, and may return early: the caller
        looks again. `idle()` is True while there is still nothing to do but wait.
        """


class MachineTime:
    """The machine's own time."""

    def monotonic_ns(self) -> int:
        return time.monotonic_ns()

    def time_ns(self) -> int:
        return time.time_ns()

    def wait(
        self,
        condition: threading.Condition,
        idle: Callable[[], bool],
        until_ns: int | None = None,
    ) -> None:
        seconds = None if until_ns is None else max(until_ns - time.monotonic_ns(), 0) / 1e9
        condition.wait(seconds)


_source: TimeSource = MachineTime()


def use(source: TimeSource) -> TimeSource:
    """Take the time from `source` from now on; returns the source that was used before."""
    global _source
    before, _source = _source, source
    return before


def monotonic_ns() -> int:
    """ns that only grow."""
    return _source.monotonic_ns()


def time_ns() -> int:
    """ns since the Unix epoch."""
    return _source.time_ns()


def patience_ns(timeout_sec: float | None) -> int | None:
    """As `deadline_ns`, for waiting on other nodes: there a negative timeout is over at once."""
    return deadline_ns(None if timeout_sec is None else max(timeout_sec, 0.0))


def deadline_ns(timeout_sec: float | None) -> int | None:
    """When a timeout (s) that begins now is over; None for None and for a negative one."""
    if timeout_sec is None or timeout_sec < 0:
        return None
    return monotonic_ns() + int(timeout_sec * 1e9)


def wait_until(
    condition: threading.Condition, holds: Callable[[], bool], until_ns: int | None
) -> bool:
    """Wait, with `condition` held, until `holds()`; returns whether it does."""
    while not holds():
        if until_ns is not None and monotonic_ns() >= until_ns:
            return False
        _source.wait(condition, lambda: not holds(), until_ns)
    return True


def wait(condition: threading.Condition, idle: Callable[[], bool], until_ns: int | None) -> None:
    """See `TimeSource.wait`."""
    _source.wait(condition, idle, until_ns)
