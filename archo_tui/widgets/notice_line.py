"""The second row of a screen while a notice is shown."""

from __future__ import annotations

from textual import events
from textual.content import Content
from textual.widgets import Static

from archo_tui.safe_text import harmless
from archo_tui.widgets.notices import Notice
from archo_tui.widgets.rows import crop

_MAX_LINES = 3  # Of a notice in a narrow terminal.
_LOOKS = {"information": ("·", ""), "warning": ("▲", "bold $warn"), "error": ("✗", "bold $bad")}


def notice_text(notice: Notice, width: int) -> Content:
    """Return ` ▲ dock: the robot is stopped                       +2 `, in at most three lines."""
    glyph, style = _LOOKS[notice.severity]
    more = f"+{notice.waiting} " if notice.waiting else ""
    room = max(width - len(f" {glyph} {more} "), 8)
    first, *rest = (line.plain for line in Content(harmless(notice.text)).wrap(room))
    if len(rest) >= _MAX_LINES:
        rest = [*rest[: _MAX_LINES - 2], " ".join(rest[_MAX_LINES - 2 :])]
    head = f" {glyph} {crop(first, room)}"
    gap = " " * (width - len(more) - Content(head).cell_length) if more else ""
    lines = [f"{head}{gap}{more}", *(f"   {crop(line, room)}" for line in rest)]
    return Content.styled("\n".join(lines), style)


class NoticeLine(Static):
    """A notice drawn over the other widgets, which keep their places; a click dismisses it."""

    DEFAULT_CSS = """
    NoticeLine {
        display: none; dock: top; layer: notice; width: 100%; height: auto; background: $panel;
    }
    """

    _shown: tuple[Notice | None, int, int] = None, 0, 0

    def show(self, notice: Notice | None, row: int, width: int) -> None:
        """Show a notice at a row of the screen, or (None) what lies beneath."""
        if (notice, row, width) == self._shown:
            return
        self._shown = notice, row, width
        if notice is not None:
            self.update(notice_text(notice, width))
            self.styles.offset = 0, row
        self.display = notice is not None

    async def on_click(self, event: events.Click) -> None:
        event.stop()
        await self.run_action("app.dismiss_notice")
