"""The search by typed words in lists: pure functions."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from enum import IntEnum
from typing import TypeVar

T = TypeVar("T")
_WORDS = re.compile(r"[^\W_]+")


class Fit(IntEnum):
    """The fit of a typed word to a name; a smaller value is a better fit."""

    WORD = 0  # A whole word of the name.
    BEGINNING = 1  # The beginning of a word.
    INSIDE = 2  # Any part of the name.
    SCATTERED = 3  # The name has its letters, in their order.
    NONE = 4


def fit(typed: str, name: str, others: str = "") -> Fit:
    """Return how well a casefolded word fits a name, or the beginnings of other words for it."""
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


def matching_rows(
    typed: str, rows: Iterable[T], names_of: Callable[[T], tuple[str, str]]
) -> Sequence[T]:
    """Return the rows that every typed word fits, the best first; all if nothing is typed.

    Letters that are only scattered over a name count where nothing fits better.
    """
    words = typed.casefold().split()

    def rank(row: T) -> tuple[Fit, int]:
        fits = [fit(word, *names_of(row)) for word in words]
        return max(fits, default=Fit.WORD), sum(fits)

    ranked = [(rank(row), row) for row in rows]
    matches = [(rank, row) for rank, row in ranked if rank[0] != Fit.NONE]
    best = sorted(matches, key=lambda match: match[0])
    is_found = best and best[0][0][0] < Fit.SCATTERED
    return [row for rank, row in best if not is_found or rank[0] < Fit.SCATTERED]


def matched_spans(typed: str, name: str) -> list[tuple[int, int]]:
    """Return the sorted spans of what typed words match in a name; they may overlap.

    Empty if casefolding changes the name's length.
    """
    lower, found = name.casefold(), []
    if len(lower) != len(name):  # Its letters stand elsewhere.
        return []
    for word in typed.casefold().split():
        begins = re.search(rf"(?<![^\W_]){re.escape(word)}", lower)
        at = lower.find(word) if begins is None else begins.start()
        if at >= 0:
            found.append((at, at + len(word)))
    return sorted(found)
