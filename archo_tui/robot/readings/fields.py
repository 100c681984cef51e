"""The reading of message fields; a value outside its range is no reading."""

from __future__ import annotations

import math
from typing import Any

from archo_tui.robot.messages.types import INTEGERS
from archo_tui.robot.messages.values import number
from archo_tui.robot_file.model import MessageField

Fields = MessageField | tuple[MessageField, ...]  # The source of one reading.


def read(given: Fields | None, message: Any) -> Any:
    """Return the value that a robot file reads from a message; None if the field is missing."""
    if isinstance(given, tuple):
        flags = [flag(_read(field, message)) for field in given]
        return True if True in flags else None if None in flags else False
    return None if given is None else _read(given, message)


def _read(field: MessageField, message: Any) -> Any:
    """Return the value of one field, compared or scaled as the robot file says."""
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
        return value  # A count stays a whole number.
    return value * field.scale + field.offset


def integer(value: Any) -> int | None:
    """Return a whole number that fits into 64 bits; None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int):
        return None
    low, high = INTEGERS["int64"]
    return value if low <= value <= high else None


def flag(value: Any) -> bool | None:
    """Return a bool; None for anything else."""
    return value if isinstance(value, bool) else None


def as_received(value: Any) -> str:
    """Return a text for a value that is no reading: a float with 6 digits, others in 20 characters.

    It may hold any characters; for None it is `None`.
    """
    return f"{value:g}" if isinstance(value, float) else str(value)[:20]


def yaw(quaternion: Any) -> float | None:
    """Return the yaw of a quaternion in degrees, -180 to 180; None for anything else.

    As tf2's getYaw, for a quaternion of any length; one of length zero has no yaw.
    """
    parts = [number(getattr(quaternion, name, None), -math.inf, math.inf) for name in "xyzw"]
    if None in parts or not any(parts):
        return None
    x, y, z, w = (part or 0.0 for part in parts)
    sine, cosine = 2.0 * (w * z + x * y), w * w + x * x - y * y - z * z
    return math.degrees(math.atan2(sine, cosine))
