"""The conversion of values to the text that a person would write, and back."""

from __future__ import annotations

import math
import re
from typing import Any

from archo_tui.safe_text import safe

# Stricter than int() and float(), which also accept `1_2` and the digits of every script.
_WHOLE = re.compile(r"[+-]?[0-9]+")
_NUMBER = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")
_INFINITE = re.compile(r"[+-]?\.?(inf|Inf|INF)|\.?(nan|NaN|NAN)")  # YAML's dot is optional.
# The lowest and the highest value of each integer type, by the names that rosidl writes.
INTEGERS = {
    f"{sign}int{bits}": (0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
} | {"octet": (0, 255)}
_DIGITS = 30  # More than any type has; further digits cannot make a number fit.


def text_of(value: Any) -> str:
    """Return a value as a person writes it, in one line that is safe to show; `--` for None."""
    if value is None:
        return "--"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(text_of(item) for item in value)}]"
    return safe(str(value))


def same(a: Any, b: Any) -> bool:
    """Return True for equal values; unlike with `==`, NaN is the same as NaN."""
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    both_nan = isinstance(a, float) and isinstance(b, float) and a != a and b != b
    return both_nan or bool(a == b)


def parse_bool(text: str) -> bool:
    """Return the bool that a word means: true, yes, on, false, no, off, in any case.

    Raises:
        ValueError: The text is another word.
    """
    words = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
    if text.lower() not in words:
        raise ValueError(f"not true or false: {text}")
    return words[text.lower()]


def fits_an_integer(value: int) -> bool:
    """Return True if an int64 or a uint64 can hold the number."""
    return INTEGERS["int64"][0] <= value <= INTEGERS["uint64"][1]


def parse_integer(text: str, limits: tuple[int, int] = INTEGERS["int64"]) -> int:
    """Return the whole number in a text of decimal digits with an optional sign.

    Args:
        text: The text; blanks around it do not matter.
        limits: The smallest and the largest number allowed.

    Raises:
        ValueError: In one line, what is wrong.
    """
    stripped = text.strip()
    if not _WHOLE.fullmatch(stripped):
        raise ValueError(f"not a whole number: {text}")
    value = int(stripped.lstrip("+-0")[:_DIGITS] or "0")
    value = -value if stripped.startswith("-") else value
    if not limits[0] <= value <= limits[1]:
        raise ValueError(f"too large for an integer: {text}")
    return value


def parse_number(text: str) -> float:
    """Return the finite number in a text, such as `-1.5` or `2e3`.

    Raises:
        ValueError: In one line, what is wrong; NaN and infinity are refused.
    """
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
    """Return the number in a text, which may also be `nan` or `inf`, with or without YAML's dot.

    Raises:
        ValueError: In one line, what is wrong.
    """
    if _INFINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return parse_number(text)
