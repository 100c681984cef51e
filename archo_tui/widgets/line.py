"""One line of text that is redrawn only when it changes, and moves nothing around it."""

from __future__ import annotations

from functools import lru_cache

from rich.style import Style
from textual.color import Color
from textual.content import Content
from textual.geometry import Region
from textual.strip import Strip
from textual.visual import Visual
from textual.widgets import Static

from archo_tui.widgets.styled import content
from archo_tui.words.state import Spans


class Line(Static):
    """A fixed line: about 100 bytes a change, nothing when the text is the same."""

    DEFAULT_CSS = "Line { height: 1; width: 1fr; text-wrap: nowrap; text-overflow: ellipsis; }"

    def __init__(self, **options: str) -> None:
        super().__init__("", **options)  # type: ignore[arg-type]
        self._shown: Content | None = None
        self._said: Spans | None = None  # what that was made of

    @property
    def link_style(self) -> Style:
        """Nothing of its own: what can be clicked looks as it is written."""
        return Style()

    def render_lines(self, crop: Region) -> list[Strip]:
        """As Textual's, but for what a line never has: border, padding, opacity.

        That is more than half of what it costs, and lines are most of what changes.
        """
        style, width = self.visual_style, self.region.width
        background = style.background
        assert background is not None  # of a widget
        strips = Visual.to_strips(self, self.visual, width, 1, style)
        drawn = strips[0] if strips else Strip([])
        drawn = drawn.adjust_cell_length(width, _blank(background))
        under = self.hover_style  # the mouse
        if under.link_id and "@click" in under.meta:
            drawn = drawn.style_links(under.link_id, self.link_style_hover)
        for line_filter in self.get_line_filters():
            drawn = drawn.apply_filter(line_filter, background)
        whole = crop.column_span == (0, width)
        return [drawn if whole else drawn.crop(*crop.column_span)] * crop.height

    def say(self, spans: Spans) -> None:
        """Show these instead; nothing is made of what is the same."""
        if spans != self._said:
            self.show(content(spans))
            self._said = spans

    def show(self, text: Content) -> None:
        """Show this instead."""
        self._said = None
        if self._shown is None or not (text is self._shown or text.is_same(self._shown)):
            self._shown = text
            self.update(text, layout=False)


@lru_cache(64)
def _blank(background: Color) -> Style:
    return Style.from_color(bgcolor=background.rich_color)
