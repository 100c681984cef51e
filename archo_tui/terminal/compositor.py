"""Textual's drawing, made cheaper: lines that have not changed are not asked for, nor kept."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from textual import events, on
from textual._compositor import ChopsUpdate, Compositor
from textual._styles_cache import StylesCache
from textual.containers import Container
from textual.geometry import Region
from textual.strip import Strip


class LayoutOnly(Container):
    """A container that only places its children: it draws nothing, what lies beneath it shows."""

    @on(events.DescendantFocus)
    @on(events.DescendantBlur)
    def stop_event(self, event: events.Event) -> None:
        """Keep focus events from bubbling up to the app, where nothing handles them."""
        event.stop()


class DirtyCompositor(Compositor):
    """A compositor that renders the lines that changed.

    Textual's own asks every widget for all its lines, which is most of the cost of a screen whose
    readings change a few times a second.
    """

    def __init__(self) -> None:
        super().__init__()
        # The spans (x1, x2) of each line that are still to be drawn; None means everything.
        self._dirty: dict[int, list[tuple[int, int]]] | None = None

    def render_partial_update(self) -> ChopsUpdate | None:
        if self._full_map_invalidated:
            # Without the update, lines that a scroll exposes may be drawn blank at first.
            _ = self.full_map
            self._cuts = None
        self._dirty = {}
        for y, x1, x2 in self._regions_to_spans(self._dirty_regions):
            self._dirty.setdefault(y, []).append((x1, x2))
        try:
            return super().render_partial_update()
        finally:
            self._dirty = None

    def _get_renders(
        self, crop: Region | None = None
    ) -> Iterable[tuple[Region, Region, list[Strip]]]:
        top, bottom = 0, self.size.height
        if self._dirty is not None:
            top, bottom = min(self._dirty, default=0), max(self._dirty, default=-1) + 1
        for widget, (region, clip) in self.visible_widgets.items():  # From front to back.
            if region.y >= bottom or region.bottom <= top or isinstance(widget, LayoutOnly):
                continue
            seen = region.intersection(clip)
            lines = [y for y in seen.line_range if self._is_dirty(y, seen)]
            if lines:
                part = Region(seen.x, lines[0], seen.width, lines[-1] + 1 - lines[0])
                yield region, part, widget.render_lines(part.translate(-region.offset))
                for y in lines:
                    self._mark_drawn(y, seen.x, seen.right)

    def _mark_drawn(self, y: int, start: int, end: int) -> None:
        """Take columns off what is still to be drawn of a line, for the widgets behind."""
        if self._dirty is None:
            return
        self._dirty[y] = [
            (x1, x2)
            for left, right in self._dirty[y]
            for x1, x2 in ((left, min(right, start)), (max(left, end), right))
            if x1 < x2
        ]

    def _is_dirty(self, y: int, seen: Region) -> bool:
        """Return True if a part of a line is still to be drawn."""
        if self._dirty is None:  # Everything is to be drawn.
            return True
        spans = self._dirty.get(y)
        if not spans:  # True of most lines.
            return False
        return any(x1 < seen.right and seen.x < x2 for x1, x2 in spans)


# Textual 8.2.8 caches it with the instance among its arguments: the last 1,024 instances stay in
# memory, each with all the lines of a widget, 0.3 MB for each time that a palette is opened.
_original: Any = StylesCache.get_inner_outer


def share_colour_cache() -> None:
    """Patch Textual to cache a widget's two colours by its arguments, not by the instance."""
    colours: Any = lru_cache(1024)(_original.__wrapped__)
    StylesCache.get_inner_outer = classmethod(colours)  # type: ignore[assignment]
