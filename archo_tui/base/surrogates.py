"""Lone surrogates: halves of a pair, which Python's texts can hold and UTF-8 cannot encode."""

from __future__ import annotations

import re

_SURROGATE = re.compile("[\ud800-\udfff]")


def has_lone_surrogate(text: str) -> bool:
    """Return True if a text cannot be encoded as UTF-8."""
    return _SURROGATE.search(text) is not None
