"""Waiting for a condition, with a deadline."""

from __future__ import annotations

import time
from collections.abc import Callable

from tests.support import clock

DEADLINE = 30.0  # s; generous, for a busy machine: a passing test never waits that long
_PATIENCE = 5  # times that, where a virtual clock says when enough has been waited
_VIRTUAL = 100.0  # s of virtual time in which everything that can happen does
_AT_LEAST = 15.0  # s of real time for what other threads have to do


class Waited:
    """How long somebody has waited, by the machine's time and the test's."""

    def __init__(self, deadline: float) -> None:
        self._deadline = deadline
        self._began, self._virtual = time.monotonic(), clock.seconds()

    def too_long(self) -> bool:
        """True when it is time to give up."""
        real = time.monotonic() - self._began
        if clock.current is None:
            return real > self._deadline
        moved = clock.seconds() - self._virtual > _VIRTUAL
        return real > _PATIENCE * self._deadline or (moved and real > _AT_LEAST)

    def __str__(self) -> str:
        return f"{time.monotonic() - self._began:.1f} s ({clock.seconds() - self._virtual:.1f} s)"


def wait_until(condition: Callable[[], object], what: str = "", deadline: float = DEADLINE) -> None:
    """Return as soon as the condition holds; fail the test when the deadline (s) has passed.

    A virtual clock is moved on meanwhile, step by step.
    """
    waited = Waited(deadline)
    while not condition():
        assert not waited.too_long(), f"waited {waited} for {what or condition}"
        step()


def step() -> None:
    """Let a little time pass: the virtual clock's, when everything rests, or the machine's."""
    virtual = clock.current
    if virtual is None or not virtual.at_rest() or not virtual.advance():
        time.sleep(clock.look())
