"""The nearest known word to a misspelt one, as every error names it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_CUTOFF = 0.6  # The default of difflib.get_close_matches.


def nearest(word: str, known: Iterable[str], cutoff: float = _CUTOFF) -> str:
    """Return the known word that is spelled most alike; "" if none is alike enough.

    Args:
        word: The word that somebody typed.
        known: The words that would do.
        cutoff: The least similarity, from 0 to 1 as difflib.SequenceMatcher.ratio has it.
    """
    return next(iter(difflib.get_close_matches(word, list(known), n=1, cutoff=cutoff)), "")


def nearest_hint(word: str, known: Iterable[str], cutoff: float = _CUTOFF) -> str:
    """Return the end of an error that names the nearest known word; "" if none is alike enough.

    An example is ` (nearest: /motor_controller)`, which begins with a space.
    """
    near = nearest(word, known, cutoff)
    return f" (nearest: {near})" if near else ""
