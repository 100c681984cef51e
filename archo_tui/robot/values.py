"""Values as a person writes them, and back."""

from __future__ import annotations

import math
import re
from typing import Any

from archo_tui.robot.text import safe

# as people write them: int() and float() also take `1_2`, and the digits of every script
_WHOLE = re.compile(r"[+-]?[0-9]+")
_NUMBER = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")
_INFINITE = re.compile(r"[+-]?\.?(inf|Inf|INF)|\.?(nan|NaN|NAN)")  # with YAML's dot or without
_DIGITS = 30  # more than any type has room for: what follows makes no number fit


def text_of(value: Any) -> str:
    """Return a value as a person writes it, in one line that is safe to show; `--` for none."""
    if value is None:
        return "--"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(text_of(item) for item in value)}]"
    return safe(str(value))


def same(one: Any, other: Any) -> bool:
    """True for equal values; NaN, which equals nothing, is the same as NaN."""
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    both_nan = isinstance(one, float) and isinstance(other, float) and one != one and other != other
    return both_nan or bool(one == other)


def parse_bool(text: str) -> bool:
    """Raises ValueError with one line that says what is wrong, as the others do."""
    words = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
    if text.lower() not in words:
        raise ValueError(f"not true or false: {text}")
    return words[text.lower()]


def parse_integer(text: str, low: int = -(2**63), high: int = 2**63 - 1) -> int:
    """A whole number within low .. high."""
    stripped = text.strip()
    if not _WHOLE.fullmatch(stripped):
        raise ValueError(f"not a whole number: {text}")
    value = int(stripped.lstrip("+-0")[:_DIGITS] or "0")
    value = -value if stripped.startswith("-") else value
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
    if not _NUMBER.fullmatch(text.strip()):
        raise ValueError(f"not a number: {text}")
    return value


def parse_any_number(text: str) -> float:
    """A number as messages hold them: `nan` and `inf` too."""
    if _INFINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return parse_number(text)
