"""What the robot says, as it is handed on: bounded, harmless, and nothing but data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import islice
from typing import Any

from archo_tui.robot.text import harmless

MOST = 100  # items of a list, or names of an object
_DEEPEST = 8  # levels of objects in objects
_LARGEST = 2**64  # nothing that ROS has is larger


def quoted(told: Any, depth: int = _DEEPEST) -> Any:
    """The same, of types that JSON has; of what is cut it is said how much is left out.

    Numbers that JSON lacks become texts.
    """
    if told is None or isinstance(told, bool):
        return told
    if isinstance(told, str):
        return harmless(told)
    if isinstance(told, (int, float)):
        is_usual = math.isfinite(told) if isinstance(told, float) else abs(told) <= _LARGEST
        return told if is_usual else f"a number that is not shown: {_in_words(told)}"
    if depth == 0 or not isinstance(told, (list, tuple, Mapping)):
        return "not shown: too deep"
    left_out = len(told) - MOST
    more = f"{left_out} more are left out"
    if isinstance(told, Mapping):
        shown = {
            harmless(str(name)): quoted(value, depth - 1)
            for name, value in islice(told.items(), MOST)
        }
        return {**shown, "...": more} if left_out > 0 else shown
    items = [quoted(value, depth - 1) for value in told[:MOST]]
    return [*items, more] if left_out > 0 else items


def _in_words(number: float) -> str:
    """`nan`, `inf`, or how many bits a large integer has."""
    return str(number) if isinstance(number, float) else f"{number.bit_length()} bits"
