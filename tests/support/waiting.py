"""Waiting for a condition, with a deadline."""

from __future__ import annotations

import time
from collections.abc import Callable

from tests.support import clock

DEADLINE = 20.0  # s; generous, for a busy machine: a passing test never waits that long


def wait_until(condition: Callable[[], object], what: str = "", deadline: float = DEADLINE) -> None:
    """Return as soon as the condition holds; fail the test when the deadline (s) has passed.

    A virtual clock is moved on meanwhile, step by step.
    """
    end = time.monotonic() + deadline
    while not condition():
        assert time.monotonic() < end, f"waited {deadline} s for {what or condition}"
        step()


def step() -> None:
    """Let a little time pass: the virtual clock's, when everything rests, or the machine's."""
    virtual = clock.current
    if virtual is None or not virtual.at_rest() or not virtual.advance():
        time.sleep(clock.LOOK)
