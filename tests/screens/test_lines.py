"""Lines draw themselves, and look as Textual would draw them."""

from __future__ import annotations

from rich.segment import Segment
from textual.strip import Strip

from archo_tui.screen.widgets.line import Line
from tests.support.console import FAST, console


def cells(strips: list[Strip]) -> list[tuple[str, str]]:
    """Each character, and how it looks."""
    segments: list[Segment] = [segment for strip in strips for segment in strip]
    return [(char, str(segment.style)) for segment in segments for char in segment.text]


async def test_what_can_be_clicked_is_lit_below_the_mouse() -> None:
    async with console(*FAST, size=(120, 36)) as op:
        footer = op.app.screen.query_one("#footer", Line)
        place = op.text.splitlines()[-1].index("r Reset") + 3
        before = cells(footer.render_lines(footer.size.region))
        await op.pilot.hover("#footer", offset=(place, 0))
        await op.until(lambda: cells(footer.render_lines(footer.size.region)) != before)
        lit = cells(footer.render_lines(footer.size.region))
        assert lit[place][1] != before[place][1]
