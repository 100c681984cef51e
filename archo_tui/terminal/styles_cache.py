"""A fix for a memory leak of Textual's cache of widget colours.

Textual 8.2.8 caches `StylesCache.get_inner_outer` with the instance among its arguments: the last
1,024 instances stay in memory, each with all the lines of a widget. A palette leaves five of them,
0.3 MB each time it is opened. The method needs its class only.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from textual._styles_cache import StylesCache

_original: Any = StylesCache.get_inner_outer


def share_colour_cache() -> None:
    """Patch Textual to cache a widget's two colours by its arguments, not by the instance."""
    colours: Any = lru_cache(1024)(_original.__wrapped__)
    StylesCache.get_inner_outer = classmethod(colours)  # type: ignore[assignment]
