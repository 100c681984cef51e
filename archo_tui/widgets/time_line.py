"""Panel 9 of a replay: where it is between begin and end, and what happened when."""

from __future__ import annotations

from textual import events
from textual.app import ComposeResult
from textual.content import Content

from archo_tui.clock import time_of_day
from archo_tui.replay.player import Player
from archo_tui.replay.window import TimelineMark
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import crop
from archo_tui.widgets.shown import Shown

_AT_ONCE = 0.05  # s
_BESIDE = 21  # cells of what stands on the line's left, with both times
_HERE, _MARK, _PAST, _TO_COME = "●", "┼", "━", "─"


class TimeLine(Panel, can_focus=True):
    """Two lines over the footer; a click goes there. Its keys are commands of a replay."""

    number, title_text = 9, "Time line"

    def __init__(self, player: Player) -> None:
        super().__init__()
        self._player = player
        self._line, self._said = Line(id="time"), Line(id="time-said")

    def compose(self) -> ComposeResult:
        yield self._line
        yield self._said

    def mark_focused(self, has_focus: bool) -> None:
        """By a colour: it has no border."""
        self.set_class(has_focus, "-focused")

    def show(self, view: Shown) -> None:
        player, width = self._player, self.size.width
        here, marks = view.now, player.marks
        how = "▶" if player.is_playing else "‖"
        left = f" {how} {player.speed:g}x"
        begin, end = time_of_day(player.start), time_of_day(player.end)
        line = line_of(player, here, marks, self._cells)
        self._line.show(Content.assemble((f"{left:<9}", "bold"), f"{begin} ", line, f" {end}"))
        said = "reading" if player.is_reading else _last(marks, here)
        more = f"   {player.unreadable} messages are unreadable" if player.unreadable else ""
        faults = "".join(f"   {fault}" for fault in player.bag.faults)
        where = f" {span(here - player.start)} of {span(player.end - player.start)}"
        text = f"{where:<17}  {said}{more}{faults}"
        self._said.show(Content(crop(text, max(width, 1))))

    @property
    def _cells(self) -> int:
        return max(self.size.width - _BESIDE - 7, 1)

    def on_click(self, event: events.Click) -> None:
        """Go where it was clicked, between the two times."""
        place = event.x - _BESIDE + 3
        if event.y == 0 and 0 <= place < self._cells:
            whole = self._player.end - self._player.start
            self._player.go_to(self._player.start + whole * place / max(self._cells - 1, 1))
            self.post_message(self.Resized(self))


def _last(marks: list[TimelineMark], here: float) -> str:
    """What happened last, all at once."""
    past = [mark for mark in marks if mark.time <= here + _AT_ONCE]
    return ", ".join(mark.text for mark in past if past[-1].time - mark.time < _AT_ONCE)


def line_of(player: Player, here: float, marks: list[TimelineMark], cells: int) -> Content:
    """`━━┼━━━●──┼────`: what is past, where it is, marks."""
    whole = max(player.end - player.start, 1e-9)

    def place(time: float) -> int:
        return round((time - player.start) / whole * (cells - 1))

    at = place(here)
    drawn = [_PAST if number < at else _TO_COME for number in range(cells)]
    for mark in marks:
        if 0 <= place(mark.time) < cells:
            drawn[place(mark.time)] = _MARK
    before, behind = "".join(drawn[:at]), "".join(drawn[at + 1 :])
    return Content.assemble((before, "$primary"), (_HERE, "bold"), (behind, "$quiet"))


def span(seconds: float) -> str:
    """`1:05`, or `1:02:03`."""
    minutes, rest = divmod(max(int(seconds), 0), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
