"""Which names fit what was typed, the best first. Pure."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from enum import IntEnum
from typing import TypeVar

T = TypeVar("T")
_WORDS = re.compile(r"[^\W_]+")


class Fit(IntEnum):
    """How well a typed word fits a name, the best first."""

    WORD = 0
    BEGINNING = 1
    INSIDE = 2
    SCATTERED = 3  # its letters, in their order
    NONE = 4


def fit(typed: str, name: str, others: str = "") -> Fit:
    """How one typed word, without case, fits a name, or other words for what that names."""
    name = name.casefold()
    words = _WORDS.findall(f"{name} {others.casefold()}")
    if typed in words:
        return Fit.WORD
    if any(word.startswith(typed) for word in words) or name.startswith(typed):
        return Fit.BEGINNING
    if typed in name:
        return Fit.INSIDE
    letters = iter(name)
    return Fit.SCATTERED if all(letter in letters for letter in typed) else Fit.NONE


def found(typed: str, rows: Iterable[T], named: Callable[[T], tuple[str, str]]) -> Sequence[T]:
    """The rows that every typed word fits, the best first; all as they stand for nothing typed.

    `named(row)` gives its name, and other words for it.
    """
    words = typed.casefold().split()

    def fits(row: T) -> tuple[Fit, int]:
        each = [fit(word, *named(row)) for word in words]
        return max(each, default=Fit.WORD), sum(each)

    ranked = [(fits(row), row) for row in rows]
    kept = [one for one in ranked if one[0][0] != Fit.NONE]
    return [row for _, row in sorted(kept, key=lambda one: one[0])]
