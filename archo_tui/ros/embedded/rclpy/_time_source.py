"""The engine's source of time: one object, which a test can replace by its own.

Timers, clocks and the timeouts of every spin and call ask it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any


class MachineTime:
    """The clocks of the machine, in ns, and how a thread waits; a test can replace them.

    `wait` releases a condition, which the caller holds, until it is notified or the time has come;
    it may return early: the caller looks again.
    """

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


_source: MachineTime = MachineTime()


def use(source: Any) -> Any:
    """Replace the source of time of the whole process, and return the previous source."""
    global _source
    before, _source = _source, source
    return before


def monotonic_ns() -> int:
    """Return the monotonic time of the current source, in ns."""
    return _source.monotonic_ns()


def time_ns() -> int:
    """Return the Unix time of the current source, in ns."""
    return _source.time_ns()


def patience_ns(timeout_sec: float | None) -> int | None:
    """Return the monotonic time, in ns, at which a wait for other nodes ends; None for no limit."""
    return deadline_ns(None if timeout_sec is None else max(timeout_sec, 0.0))


def deadline_ns(timeout_sec: float | None) -> int | None:
    """Return the monotonic time (ns) at which a timeout from now ends; None for no limit."""
    if timeout_sec is None or timeout_sec < 0:
        return None
    return monotonic_ns() + int(timeout_sec * 1e9)


def wait_until(
    condition: threading.Condition, holds: Callable[[], bool], until_ns: int | None
) -> bool:
    """Block until `holds()` is true; return False if `until_ns` came first."""
    while not holds():
        if until_ns is not None and monotonic_ns() >= until_ns:
            return False
        _source.wait(condition, lambda: not holds(), until_ns)
    return True


def wait(condition: threading.Condition, idle: Callable[[], bool], until_ns: int | None) -> None:
    """Wait as `MachineTime.wait` of the current source does."""
    _source.wait(condition, idle, until_ns)
