"""The base of widgets that draw their lines themselves."""

from __future__ import annotations

from rich.style import Style
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget


class LineWidget(Widget):
    """A widget with a `render_line`; the last base of a class, since the first names the styles."""

    base = Style()  # The style of a blank cell, while lines are rendered.

    def render_lines(self, crop: Region) -> list[Strip]:
        self.base = self.rich_style  # Computed once: it depends on all ancestors.
        return super().render_lines(crop)
