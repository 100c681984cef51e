"""The bases of widgets that draw their lines themselves, and redraw only what changes."""

from __future__ import annotations

from collections.abc import Sequence

from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from archo_tui.errors import in_one_line
from archo_tui.safe_text import harmless
from archo_tui.text.state import Spans
from archo_tui.widgets.styled import rich_style


def not_drawn(error: Exception) -> str:
    """Return the text in the place of what could not be drawn."""
    return harmless(f"✗ cannot be drawn: {in_one_line(error)}")


class LineWidget(Widget):
    """The base of widgets that draw their lines in a `render_line` of their own.

    List it last among the bases: Textual looks for styles by the names of the first ones.
    """

    base = Style()  # Of a blank cell, set before lines are rendered.

    def render_lines(self, crop: Region) -> list[Strip]:
        self.base = self.rich_style  # Computed once: it depends on all ancestors.
        try:
            return super().render_lines(crop)
        except Exception as error:  # The other widgets go on.
            line = Strip([Segment(not_drawn(error), self.base)]).crop_extend(
                *crop.column_span, self.base
            )
            return [line] * crop.height


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
