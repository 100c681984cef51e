"""The sanitizing of what the robot says: bounded in size, harmless to print, only data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import islice
from typing import Any

from archo_tui.robot.messages.values import fits_an_integer
from archo_tui.safe_text import harmless

MAX_ITEMS = 100  # Of a list or an object.
_MAX_DEPTH = 8  # Levels of nesting.


def sanitize(value: Any, depth: int = _MAX_DEPTH) -> Any:
    """Return a copy of a value in JSON's types, harmless to print, with a note for whatever is cut.

    Lists keep 100 items, texts 500 characters. Numbers that are not finite, and whole ones beyond
    64 bits, become texts; what is nested deeper than `depth` becomes a note.
    """
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return harmless(value)
    if isinstance(value, (int, float)):
        is_usual = math.isfinite(value) if isinstance(value, float) else fits_an_integer(value)
        return value if is_usual else f"a number that is not shown: {_describe_number(value)}"
    if depth == 0 or not isinstance(value, (list, tuple, Mapping)):
        return "not shown: too deep"
    left_out = len(value) - MAX_ITEMS
    more = f"{left_out} more are left out"
    if isinstance(value, Mapping):
        shown = {
            harmless(str(name)): sanitize(item, depth - 1)
            for name, item in islice(value.items(), MAX_ITEMS)
        }
        return {**shown, "...": more} if left_out > 0 else shown
    items = [sanitize(item, depth - 1) for item in value[:MAX_ITEMS]]
    return [*items, more] if left_out > 0 else items


def _describe_number(number: float) -> str:
    return str(number) if isinstance(number, float) else f"{number.bit_length()} bits"
