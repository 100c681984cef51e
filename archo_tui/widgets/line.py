"""One line of text that is redrawn only when it changes, and moves nothing around it."""

from __future__ import annotations

from rich.style import Style
from textual.content import Content
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
