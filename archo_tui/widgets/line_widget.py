"""The base of widgets that draw their lines themselves."""

from __future__ import annotations

from rich.style import Style
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget


class LineWidget(Widget):
    """The base of widgets that draw their lines in a `render_line` of their own.

    List it last among the bases: Textual looks for styles by the names of the first ones.

    Attributes:
        base: The style of a blank cell, set before lines are rendered.
    """

    base = Style()

    def render_lines(self, crop: Region) -> list[Strip]:
        self.base = self.rich_style  # Computed once: it depends on all ancestors.
        return super().render_lines(crop)
