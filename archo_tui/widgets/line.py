"""A line of text that is redrawn only when it changes, and moves nothing around it."""

from __future__ import annotations

from rich.style import Style
from textual.content import Content
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
