"""A widget that draws its lines itself."""

from __future__ import annotations

from rich.style import Style
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget


class ByLines(Widget):
    """Base of those with a `render_line`; the last one, for the first gives Textual the styles."""

    base = Style()  # how a blank of it looks, while it is drawn

    def render_lines(self, crop: Region) -> list[Strip]:
        self.base = self.rich_style  # once, not for each line: it looks at all that is around it
        return super().render_lines(crop)
