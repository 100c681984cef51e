"""The screen of a replay inside of the live console, whose state is told in a line above it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.content import Content
from textual.geometry import Size

from archo_tui.clock import time_of_day
from archo_tui.recordings.replay.player import Player
from archo_tui.robot.state.snapshot import Latch, Snapshot
from archo_tui.safe_text import harmless
from archo_tui.screens.dismissable import Dismissable
from archo_tui.screens.main import MainScreen
from archo_tui.station.alarms import Alarm, AlarmState
from archo_tui.station.conditions import Priority
from archo_tui.terminal.app import start_worker
from archo_tui.widgets.bars import activity, contact, past_alarm
from archo_tui.widgets.line import Line
from archo_tui.widgets.rows import crop
from archo_tui.widgets.screen_state import ScreenState
from archo_tui.widgets.time_line import TimeLine


class ReplayScreen(MainScreen, Dismissable[None]):
    """The panels of a recorded robot, with a line above them that tells what the live robot does.

    The player is closed with the screen.
    """

    def __init__(
        self, snapshot: Snapshot, size: Size, player: Player, update: Callable[[], None]
    ) -> None:
        super().__init__(snapshot, size, TimeLine(snapshot, player))
        self._player, self._update = player, update
        self._live = Line(id="live")
        self.rows_around += 1
        self._live_text, self._recorded_head = Content(""), list[Content]()

    def compose(self) -> ComposeResult:
        yield self._live
        yield from super().compose()

    def on_mount(self) -> None:
        start_worker(self, partial(self._player.follow, self._update), "play")

    def on_unmount(self) -> None:
        self._player.close()

    def show_view(self, view: ScreenState) -> None:
        """Show what the live robot does in the line at the top, in dialogs too."""
        self._live_text = live_line(view, self.size.width)
        self._live.show(self._live_text)
        self.show_head(self._recorded_head)

    def show_head(self, lines: list[Content]) -> None:
        """Show the line of the live robot and those of the recording at the top of open dialogs."""
        self._recorded_head = lines
        super().show_head([self._live_text, *lines])

    def on_main_screen_broken(self, message: MainScreen.Broken) -> None:
        """Show as a notification that a panel cannot be drawn: it is no event of the live robot."""
        message.stop()
        self.notify(message.text, severity="error", markup=False)


_MIN_ALARM = 12  # Cells of an alarm's text; for fewer, the robot's name makes room.


def live_line(view: ScreenState, width: int) -> Content:
    """Return ` LIVE ARCHO   ● online   ✗ STOPPED: look for the cause      12:04:32   q back `.

    If space is short, the robot's name and the remaining way are left out first, then the number of
    alarms and the request, then the time; at last the alarm is cut.
    """
    snapshot = view.snapshot
    shown = [alarm for alarm in view.alarms if alarm.state != AlarmState.SHELVED]
    does, left = activity(view)
    alarms = _alarm_texts(shown[0]) if shown else []
    news = alarms[0] if alarms else ""
    if news and (snapshot.is_at_rest or snapshot.latch is Latch.UNCERTAIN):
        does = "" if "STOP" in shown[0].text else does  # The alarm says it.
    others = len(shown) - 1
    more = [f"+{others} more alarm{'s' * (others > 1)}"] if others > 0 else []
    more += ["an assistant asks"] if view.requests else []
    name, back = harmless(snapshot.file.name), f"{view.key('quit')} back "
    time = time_of_day(int(view.time))
    for known, behind in (
        ([name, contact(view), does, left], [*more, time, back]),
        ([contact(view), does], [*more, time, back]),
        ([contact(view), does], [time, back]),
        ([contact(view), does], [back]),
    ):
        head, tail = ("   ".join(filter(None, texts)) for texts in (["LIVE", *known], behind))
        room = width - cell_len(f" {head}      {tail}")
        if room >= (_MIN_ALARM if news else 0):
            break
    news = next((text for text in alarms if cell_len(text) <= room), news)
    text = f" {head}   {crop(news, room)}" if news and room > 1 else crop(f" {head}", width)
    gap = width - cell_len(text) - cell_len(tail)
    line = Content(f"{text}{' ' * gap}{tail}" if gap > 0 else text)
    return line.stylize(_style(view))


def _alarm_texts(alarm: Alarm) -> list[str]:
    """Return the full and the short text of an alarm with its glyph; of a past one with `was: `."""
    texts = [alarm.text, alarm.short_text]
    if alarm.until is not None:
        texts = [past_alarm(alarm), f"was: {alarm.short_text}"]
    return [f"{alarm.priority.glyph} {harmless(text)}" for text in texts]


def _style(view: ScreenState) -> str:
    """Return the style of the line, reversed while the live robot needs the operator."""
    snapshot = view.snapshot
    alarms = [alarm for alarm in view.alarms if alarm.state == AlarmState.UNACKNOWLEDGED]
    is_grave = any(alarm.priority == Priority.HIGH for alarm in alarms)
    if is_grave or snapshot.latch is Latch.UNCERTAIN:
        return "bold $bad reverse"
    return "bold $warn reverse" if alarms or snapshot.is_at_rest else "bold"
