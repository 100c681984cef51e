"""One line of text that is redrawn only when it changes, and moves nothing around it."""

from __future__ import annotations

from rich.style import Style
from textual.content import Content
from textual.widgets import Static


class Line(Static):
    """A fixed line: about 100 bytes a change, nothing when the text is the same."""

    DEFAULT_CSS = "Line { height: 1; width: 1fr; text-wrap: nowrap; text-overflow: ellipsis; }"

    def __init__(self, **options: str) -> None:
        super().__init__("", **options)  # type: ignore[arg-type]
        self._shown: Content | None = None

    @property
    def link_style(self) -> Style:
        """Nothing of its own: what can be clicked looks as it is written."""
        return Style()

    def show(self, content: Content) -> None:
        """Show this instead."""
        if self._shown is None or not content.is_same(self._shown):
            self._shown = content
            self.update(content, layout=False)
