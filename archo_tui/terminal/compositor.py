"""Draws what changed, and asks only those widgets and lines for it that are seen there."""

from __future__ import annotations

from collections.abc import Iterable

from textual import events, on
from textual._compositor import ChopsUpdate, Compositor
from textual.containers import Container
from textual.geometry import Region
from textual.strip import Strip


class Bare(Container):
    """Only lays out what it contains, and is not drawn itself: what is beneath it shows."""

    @on(events.DescendantFocus)
    @on(events.DescendantBlur)
    def stop_event(self, event: events.Event) -> None:
        """Nobody waits for it, all the way up to the app."""
        event.stop()


class DirtyCompositor(Compositor):
    """Textual's asks every widget for all its lines, however little of the screen has changed.

    That is most of what a screen costs whose readings change a few times a second.
    """

    def __init__(self) -> None:
        super().__init__()
        # spans (x1, x2) by line that nobody has drawn yet; None for all
        self._dirty: dict[int, list[tuple[int, int]]] | None = None

    def render_partial_update(self) -> ChopsUpdate | None:
        if self._full_map_invalidated:
            # brought up to date: else what a scroll exposes may first be drawn blank
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
        for widget, (region, clip) in self.visible_widgets.items():  # from front to back
            if region.y >= bottom or region.bottom <= top or isinstance(widget, Bare):
                continue
            seen = region.intersection(clip)
            lines = [y for y in seen.line_range if self._is_dirty(y, seen)]
            if lines:
                part = Region(seen.x, lines[0], seen.width, lines[-1] + 1 - lines[0])
                yield region, part, widget.render_lines(part.translate(-region.offset))
                for y in lines:
                    self._cover(y, seen.x, seen.right)

    def _cover(self, y: int, start: int, end: int) -> None:
        """Whatever is behind what has been drawn there is not asked for it."""
        if self._dirty is None:
            return
        self._dirty[y] = [
            (x1, x2)
            for left, right in self._dirty[y]
            for x1, x2 in ((left, min(right, start)), (max(left, end), right))
            if x1 < x2
        ]

    def _is_dirty(self, y: int, seen: Region) -> bool:
        """Whether a line of a widget is to be drawn, or a part of it."""
        if self._dirty is None:  # all
            return True
        spans = self._dirty.get(y)
        if not spans:  # as most lines have it
            return False
        return any(x1 < seen.right and seen.x < x2 for x1, x2 in spans)
