"""The notices: messages that are shown one at a time over the second row, and disappear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from textual import events
from textual.content import Content
from textual.notifications import SeverityLevel
from textual.widgets import Static

from archo_tui.safe_text import harmless
from archo_tui.widgets.rows import crop

# A notice waits behind graver ones for so many times its duration: after that it would tell of what
# is long past.
_MAX_WAIT = 2
_GRAVITY: tuple[SeverityLevel, ...] = ("information", "warning", "error")


class Notice(NamedTuple):
    """A message to the operator."""

    text: str
    severity: SeverityLevel
    waiting: int = 0  # The number of other notices that have not gone yet.


@dataclass
class _Entry:
    notice: Notice
    duration: float  # Seconds for which it is shown.
    # The monotonic time at which it goes, shown or not; None until the first `Notices.update`. Its
    # first showing sets the time anew.
    until: float | None = None
    was_shown: bool = False


class Notices:
    """The notices that have not gone yet, of which the gravest is shown, and of equals the newest.

    The duration of a notice begins when it is first shown, and runs on while another one hides it.
    A notice that has waited for twice its duration is dropped unseen.
    """

    def __init__(self) -> None:
        self._entries: list[_Entry] = []

    def add(self, text: str, severity: SeverityLevel, duration: float) -> None:
        """Add a notice for `duration` seconds, in place of an equal one, with its blanks joined."""
        notice = Notice(" ".join(text.split()), severity)
        self._entries = [entry for entry in self._entries if entry.notice != notice]
        self._entries.append(_Entry(notice, duration))

    def update(self, now: float) -> Notice | None:
        """Remove the notices whose time is over, and return the one to show, whose time begins."""
        self._entries = [e for e in self._entries if e.until is None or now < e.until]
        entry = self._gravest()
        if entry is None:
            return None
        for waiting in self._entries:
            if waiting.until is None:
                waiting.until = now + _MAX_WAIT * waiting.duration
        if not entry.was_shown:
            entry.until, entry.was_shown = now + entry.duration, True
        return entry.notice._replace(waiting=len(self._entries) - 1)

    def dismiss(self) -> None:
        """Remove the notice that is shown, if any; the next one takes its place."""
        entry = self._gravest()
        if entry is not None:
            self._entries.remove(entry)

    def clear(self) -> None:
        """Remove all notices."""
        self._entries.clear()

    def _gravest(self) -> _Entry | None:
        """Return the newest of the gravest notices; None if there is none."""
        return max(
            reversed(self._entries), key=lambda e: _GRAVITY.index(e.notice.severity), default=None
        )


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
