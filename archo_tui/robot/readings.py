"""What a message's fields hold, checked: a value out of its range is not a reading."""

from __future__ import annotations

import math
from typing import Any

from archo_tui.robot_file.model import MessageField

_INT64 = 2**63


Fields = MessageField | tuple[MessageField, ...]  # of one reading


def read(given: Fields | None, message: Any) -> Any:
    """Return what a robot file makes of a message; None when there is no such field.

    Of several fields: true when one of them is, false when all of them are.
    """
    if isinstance(given, tuple):
        flags = [flag(_read(field, message)) for field in given]
        return True if True in flags else None if None in flags else False
    return None if given is None else _read(given, message)


def _read(field: MessageField, message: Any) -> Any:
    value = message
    for name in field.field.split("."):
        value = getattr(value, name, None)
    if value is None:
        return None
    if field.equals is not None:
        return bool(value == field.equals)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    if field.beyond is not None:
        return abs(value) > field.beyond if math.isfinite(value) else None
    if (field.scale, field.offset) == (1.0, 0.0):
        return value  # a count stays a whole number
    return value * field.scale + field.offset


def number(value: Any, low: float, high: float) -> float | None:
    """A number within low .. high, or None, also for NaN and a bool."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if math.isfinite(value) and low <= value <= high else None


def integer(value: Any) -> int | None:
    """A whole number of 64 bits, or None."""
    if isinstance(value, bool) or not isinstance(value, int):
        return None
    return value if -_INT64 <= value < _INT64 else None


def flag(value: Any) -> bool | None:
    """True or false, or None for anything else."""
    return value if isinstance(value, bool) else None


def as_received(value: Any) -> str:
    """A value that is not a reading, in few characters."""
    return f"{value:g}" if isinstance(value, float) else str(value)[:20]
