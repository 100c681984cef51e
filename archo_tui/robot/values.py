"""Values as a person writes them, and back."""

from __future__ import annotations

import math
from typing import Any


def text_of(value: Any) -> str:
    """A value as a person writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(text_of(item) for item in value)}]"
    return str(value)


def parse_bool(text: str) -> bool:
    """Raises ValueError with one line that says what is wrong, as the others do."""
    words = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
    if text.lower() not in words:
        raise ValueError(f"not true or false: {text}")
    return words[text.lower()]


def parse_integer(text: str, low: int = -(2**63), high: int = 2**63 - 1) -> int:
    """A whole number within low .. high."""
    try:
        value = int(text, 10)
    except ValueError:
        raise ValueError(f"not a whole number: {text}") from None
    if not low <= value <= high:
        raise ValueError(f"too large for an integer: {text}")
    return value


def parse_number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"not a number: {text}") from None
    if not math.isfinite(value):
        raise ValueError(f"not a finite number: {text}")
    return value
