"""The messages that are shown over the second row, and disappear by themselves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from textual import events
from textual.content import Content
from textual.notifications import SeverityLevel
from textual.widgets import Static

from archo_tui.safe_text import harmless
from archo_tui.widgets.rows import crop

MAX_ROWS = 3
# Seconds; a warning is a refusal, which also goes when its cause ends.
DURATIONS: dict[SeverityLevel, float] = {"information": 5, "warning": 8, "error": 12}
_LOOKS = {"information": ("·", ""), "warning": ("▲", "bold $warn"), "error": ("✗", "bold $bad")}


class Notice(NamedTuple):
    """A message to the operator."""

    text: str
    severity: SeverityLevel
    until: float  # Monotonic time, in s.
    still_holds: Callable[[], object] = lambda: True  # False once the cause of a refusal is over.


def with_newest(notices: Sequence[Notice], new: Notice) -> list[Notice]:
    """Return the notices to show with a new one, the newest first, in place of an equal one.

    Of more than MAX_ROWS, the oldest of the least grave goes.
    """
    others = [notice for notice in notices if notice.text != new.text]
    if len(others) == MAX_ROWS:
        others.remove(min(reversed(others), key=lambda notice: DURATIONS[notice.severity]))
    return [new, *others]


def notice_text(notices: Sequence[Notice], width: int) -> Content:
    """Return ` ▲ dock: the robot is stopped`, a row each; one alone has up to three rows."""
    lines, room = [], max(width - 4, 8)  # A blank, the glyph and a blank; one at the end.
    for notice in notices:
        glyph, style = _LOOKS[notice.severity]
        rows = [row.plain for row in Content(harmless(notice.text)).wrap(room)]
        most = MAX_ROWS if len(notices) == 1 else 1
        rows = [*rows[: most - 1], " ".join(rows[most - 1 :])]
        text = "\n   ".join(crop(row, room) for row in rows if row)
        lines.append(Content.styled(f" {glyph} {text}", style))
    return Content("\n").join(lines)


class NoticeLine(Static):
    """The notices, drawn over the other widgets of a main screen; a click dismisses them."""

    _shown: tuple[Sequence[Notice], int] = (), 0
    rows = 1  # Of the text.

    def show(self, notices: Sequence[Notice], width: int) -> None:
        """Show notices, or (none) what lies beneath."""
        if (notices, width) != self._shown:
            self._shown = notices, width
            text = notice_text(notices, width)
            self.rows = text.plain.count("\n") + 1
            self.update(text)
            self.display = bool(notices)

    def on_click(self, event: events.Click) -> None:
        event.stop()
        self.app.clear_notifications()
