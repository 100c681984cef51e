"""The nearest known word to a misspelt one, as every error names it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_CUTOFF = 0.6  # The default of difflib.get_close_matches.


def nearest(word: str, known: Iterable[str], cutoff: float = _CUTOFF) -> str:
    """Return the known word that is spelled most alike; "" if none is alike enough."""
    return next(iter(difflib.get_close_matches(word, list(known), n=1, cutoff=cutoff)), "")


def nearest_hint(word: str, known: Iterable[str], cutoff: float = _CUTOFF) -> str:
    """Return ` (nearest: /motor_controller)`, the end of an error; "" if none is alike enough."""
    near = nearest(word, known, cutoff)
    return f" (nearest: {near})" if near else ""
