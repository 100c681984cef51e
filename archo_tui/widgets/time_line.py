"""The last panel of a replay: the position between begin and end, and marks of what happened."""

from __future__ import annotations

from textual import events
from textual.app import ComposeResult
from textual.content import Content

from archo_tui.clock import time_of_day
from archo_tui.recordings.replay.player import Player, TimelineMark
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.panels import PANELS
from archo_tui.widgets.rows import crop
from archo_tui.widgets.screen_state import ScreenState

_TOGETHER = 0.05  # Seconds between marks that count as one moment.
_LEFT_WIDTH = 21  # Cells of the speed and of both times.
_HERE, _MARK, _PAST, _FUTURE = "●", "┼", "━", "─"


class TimeLine(Panel, can_focus=True):
    """The last panel of a replay, two rows without a border: a line with the position, and text."""

    number, title_text = len(PANELS) + 1, "Time line"

    def __init__(self, snapshot: Snapshot, player: Player) -> None:
        super().__init__(snapshot)
        self._player = player
        self._line, self._status = Line(id="time"), Line(id="time-said")

    def compose(self) -> ComposeResult:
        yield self._line
        yield self._status

    def show(self, view: ScreenState) -> None:
        player, width = self._player, self.size.width
        here, marks = view.now, player.marks
        how = "▶" if player.is_playing else "‖"
        left = f" {how} {player.speed:g}x"
        begin, end = time_of_day(player.start), time_of_day(player.end)
        line = draw_time_line(player, here, marks, self._cells)
        self._line.show(Content.assemble((f"{left:<9}", "bold"), f"{begin} ", line, f" {end}"))
        status = "reading" if player.is_reading else _last_marks(marks, here)
        more = f"   {player.unreadable} messages are unreadable" if player.unreadable else ""
        faults = "".join(f"   {fault}" for fault in player.bag.faults)
        where = (
            f" {duration_text(here - player.start)} of {duration_text(player.end - player.start)}"
        )
        text = f"{where:<17}  {status}{more}{faults}"
        self._status.show(Content(crop(text, max(width, 1))))

    @property
    def _cells(self) -> int:
        return max(self.size.width - _LEFT_WIDTH - 7, 1)

    def on_click(self, event: events.Click) -> None:
        """Move the position to where the line was clicked, and have the panel shown at once."""
        place = event.x - _LEFT_WIDTH + 3
        if event.y == 0 and 0 <= place < self._cells:
            whole = self._player.end - self._player.start
            self._player.go_to(self._player.start + whole * place / max(self._cells - 1, 1))
            self.post_message(self.Outdated(self))


def _last_marks(marks: list[TimelineMark], here: float) -> str:
    """Return the text of the last mark up to a Unix time, with those less than 0.05 s before it."""
    past = [mark for mark in marks if mark.time <= here + _TOGETHER]
    return ", ".join(mark.text for mark in past if past[-1].time - mark.time < _TOGETHER)


def draw_time_line(player: Player, here: float, marks: list[TimelineMark], cells: int) -> Content:
    """Return `━━┼━━━●──┼────`: the past, the position (in Unix time), the rest, and the marks."""
    whole = max(player.end - player.start, 1e-9)

    def cell_of(time: float) -> int:
        return round((time - player.start) / whole * (cells - 1))

    at = cell_of(here)
    drawn = [_PAST if number < at else _FUTURE for number in range(cells)]
    for mark in marks:
        if 0 <= cell_of(mark.time) < cells:
            drawn[cell_of(mark.time)] = _MARK
    before, behind = "".join(drawn[:at]), "".join(drawn[at + 1 :])
    return Content.assemble((before, "$primary"), (_HERE, "bold"), (behind, "$quiet"))


def duration_text(seconds: float) -> str:
    """Return a duration as `1:05`, or with hours as `1:02:03`; a negative one as `0:00`."""
    minutes, rest = divmod(max(int(seconds), 0), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
