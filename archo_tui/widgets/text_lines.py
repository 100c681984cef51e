"""Rows of text in tones, for what is drawn as a whole, such as a plot."""

from __future__ import annotations

from collections.abc import Sequence

from rich.segment import Segment
from textual.geometry import Region
from textual.strip import Strip

from archo_tui.widgets.line_widget import LineWidget
from archo_tui.widgets.styled import rich_style
from archo_tui.words.state import Spans


class TextLines(LineWidget):
    """A widget with rows of text, such as a plot, of which only those that changed are redrawn."""

    DEFAULT_CSS = "TextLines { height: 1fr; width: 1fr; }"

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._lines: Sequence[Spans] = ()

    def show(self, lines: Sequence[Spans]) -> None:
        """Show these lines in place of those before; the rows that differ are redrawn."""
        before, self._lines = self._lines, lines
        for y in range(max(len(before), len(lines))):
            if list(before[y : y + 1]) != list(lines[y : y + 1]):
                self.refresh(Region(0, y, self.size.width, 1))

    def render_line(self, y: int) -> Strip:
        base, variables = self.base, self.app.theme_variables
        line = self._lines[y] if y < len(self._lines) else ()
        segments = [Segment(text, base + rich_style(tone, variables)) for text, tone in line]
        return Strip(segments).crop_extend(0, self.size.width, base)
