"""A line of text that is redrawn only when it changes, and moves nothing around it."""

from __future__ import annotations

from functools import lru_cache

from rich.style import Style
from textual.color import Color
from textual.content import Content
from textual.geometry import Region
from textual.strip import Strip
from textual.visual import Visual
from textual.widgets import Static

from archo_tui.text.state import Spans
from archo_tui.widgets.styled import content


class Line(Static):
    """A widget of one line of text that is redrawn only when its text changes."""

    DEFAULT_CSS = "Line { height: 1; width: 1fr; text-wrap: nowrap; text-overflow: ellipsis; }"

    def __init__(self, **options: str) -> None:
        super().__init__("", **options)  # type: ignore[arg-type]
        self._content: Content | None = None
        self._spans: Spans | None = None  # What the content was made of.

    @property
    def link_style(self) -> Style:
        """Return no style, so that text that can be clicked looks as it was written."""
        return Style()

    def render_lines(self, crop: Region) -> list[Strip]:
        """Return the line as Textual renders it, but without border, padding and opacity.

        A line never has these, and they are more than half of the cost of a rendering.
        """
        style, width = self.visual_style, self.region.width
        background = style.background
        assert background is not None  # A widget always has one.
        strips = Visual.to_strips(self, self.visual, width, 1, style)
        drawn = strips[0] if strips else Strip([])
        drawn = drawn.adjust_cell_length(width, _blank(background))
        hovered = self.hover_style  # The style under the mouse.
        if hovered.link_id and "@click" in hovered.meta:
            drawn = drawn.style_links(hovered.link_id, self.link_style_hover)
        for line_filter in self.get_line_filters():
            drawn = drawn.apply_filter(line_filter, background)
        whole = crop.column_span == (0, width)
        return [drawn if whole else drawn.crop(*crop.column_span)] * crop.height

    def show_spans(self, spans: Spans) -> None:
        """Show a text made of spans; equal spans change nothing."""
        if spans != self._spans:
            self.show(content(spans))
            self._spans = spans

    def show(self, text: Content) -> None:
        """Show a text; an equal one is not drawn again."""
        self._spans = None
        if self._content is None or not (text is self._content or text.is_same(self._content)):
            self._content = text
            self.update(text, layout=False)


@lru_cache(64)
def _blank(background: Color) -> Style:
    return Style.from_color(bgcolor=background.rich_color)
