"""What a message's fields hold, checked: a value out of its range is no reading."""

from __future__ import annotations

import math
from typing import Any

BATTERY_TYPES = {  # field of each by what it means; of another type nothing is guessed
    "archo_interfaces/msg/BatteryStatus": {
        "percentage": "percentage",
        "voltage": "voltage",
        "charging": "is_charging",
        "health": "battery_health",
    },
    "std_msgs/msg/Float32": {"percentage": "data"},
}
MOTOR_TYPES = {
    "archo_interfaces/msg/MotorStatus": {
        "ticks": "encoder_ticks",
        "speed": "speed",
        "moving": "moving",
        "stopped": "emergency_stopped",
    },
}
_INT64 = 2**63


def number(value: Any, low: float, high: float) -> float | None:
    """A number within low .. high, or None; NaN and a bool are none."""
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
    """A value that is no reading, in few characters."""
    return f"{value:g}" if isinstance(value, float) else str(value)[:20]
