"""Lets go of what was drawn of widgets that have gone.

As it comes (Textual 8.2.8), `StylesCache.get_inner_outer` is cached with the instance among its
arguments: the last 1,024 instances stay, each with all the lines of a widget. A palette leaves five
of them: 0.3 MB each time it is opened. The method needs its class only.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from textual._styles_cache import StylesCache

_inner_outer: Any = StylesCache.get_inner_outer


def share_colours() -> None:
    """Cache the two colours by their arguments, not by the instance that asks; once a process."""
    colours: Any = lru_cache(1024)(_inner_outer.__wrapped__)
    StylesCache.get_inner_outer = classmethod(colours)  # type: ignore[assignment]
