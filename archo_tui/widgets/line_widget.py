"""The base of widgets that draw their lines themselves."""

from __future__ import annotations

from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from archo_tui.errors import in_one_line
from archo_tui.safe_text import harmless


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
