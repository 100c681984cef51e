"""The screen of `archo-tui replay`: its time line, and the commands that change nothing."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from textual import events
from textual.app import ComposeResult
from textual.content import Content

from archo_tui.base.clock import time_of_day
from archo_tui.base.handover import CONSOLE_SOCKET
from archo_tui.recordings.replay.player import Player, TimelineMark
from archo_tui.recordings.replay.station import NOTHING_STOPPED
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import RobotFile
from archo_tui.screen.commands import registry
from archo_tui.screen.commands.base import (
    EVERYWHERE,
    IN_PANEL,
    NOT_TYPING,
    Command,
    Desk,
    PanelKey,
    everywhere,
)
from archo_tui.screen.commands.console import Quit, Suspend
from archo_tui.screen.dialog import ShowText
from archo_tui.screen.main import PANELS
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.panel import Panel, ScreenState
from archo_tui.text.alarm import timeline
from archo_tui.text.columns import crop
from archo_tui.verbs.verb import Verb

_QUIT = "Quit the replay, also while typing"
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


def replay_commands(player: Player, verbs: Mapping[str, Verb]) -> Sequence[Command]:
    """Return the time line's commands, all of the console that change nothing, and four others.

    The keys of those that act say that nothing was sent.
    """
    commands = registry(player.file, verbs)
    panels = [command for command in commands if isinstance(command, PanelKey)]
    panels[0].footer_key = f"1-{TimeLine.number}"
    # The terminal of a console that plays it is only lent.
    is_lent = CONSOLE_SOCKET in os.environ
    shown = [c for c in commands if c.in_replay and not (is_lent and isinstance(c, Suspend))]
    own = *_time_line_keys(player), *shown, TimeLineKey(player.file), ShowRecordedAlarms(player)
    used = {command.key for command in own}
    acting = (c for c in commands if c.verbs and c.key and c.where == NOT_TYPING)
    not_sent = (NotSent(c) for c in acting if c.key not in used)
    stop = StopConsole() if is_lent else RefuseStop()
    # The footer is cut behind the first ones.
    quit_key = everywhere(QuitReplay(), "quit_everywhere", "ctrl+q", _QUIT)
    return stop, *own, *not_sent, CopySelection(), QuitReplay(), quit_key


class NotSent(Command):
    """The key of a command that acts on a robot, which says in a replay that nothing was sent."""

    is_listed = False

    def __init__(self, command: Command) -> None:
        self.id, self.key, self.help = command.id, command.key, command.help

    def run(self, desk: Desk) -> None:
        key = desk.view.key("quit")
        desk.show_message(f"REPLAY: {self.id} was not sent: press {key} to leave the replay.")


class TimeLineKey(PanelKey):
    def __init__(self, robot: RobotFile) -> None:
        super().__init__(TimeLine, robot)
        self.id = "time_line"


class MoveInTime(Command):
    """A key of the time line, whose move may return a message."""

    where, panel = IN_PANEL, TimeLine

    def __init__(
        self,
        id: str,
        key: str,
        help: str,
        move: Callable[[], object],
        footer: str = "",
        footer_key: str = "",
    ) -> None:
        self.id, self.key, self.help, self._move = id, key, help, move
        self.footer, self.footer_key = footer, footer_key

    def run(self, desk: Desk) -> None:
        message = self._move()
        desk.update_screen()
        if isinstance(message, str) and message:
            desk.show_message(message)


def _time_line_keys(player: Player) -> list[MoveInTime]:
    def step(seconds: float) -> Callable[[], None]:
        return lambda: player.go_to(player.position + seconds)

    def mark(by: int, where: str) -> Callable[[], str]:
        missing = f"There is no mark {where} this moment."
        return lambda: missing if player.step_mark(by) is None else ""

    def play_or_pause() -> None:
        player.play(on=not player.is_playing)

    def end() -> None:
        player.play(on=False)
        player.go_to(player.end)

    key, begin = MoveInTime, partial(player.go_to, player.start)
    slower, faster = partial(player.change_speed, -1), partial(player.change_speed, 1)
    times, marks = "0.25 to 16 times as fast as it was", "an alarm, a command, the end of a goal"
    return [
        key("play", "space", "Play, or pause", play_or_pause, "Play"),
        key("back", "left", "1 s back", step(-1.0)),
        key("on", "right", "1 s on", step(1.0), "1 s", "←→"),
        key("back_ten", "shift+left", "10 s back", step(-10.0)),
        key("on_ten", "shift+right", "10 s on", step(10.0)),
        key("begin", "home", "To the beginning of the recording", begin),
        key("end", "end", "To the end of the recording", end),
        key("message_before", "comma", "To the message before", partial(player.step_message, -1)),
        key("message_after", "full_stop", "To the next message", partial(player.step_message, 1)),
        key("slower", "left_curly_bracket", f"Play slower: {times}", slower),
        key("faster", "right_curly_bracket", f"Play faster: {times}", faster, "Speed", "{}"),
        key("next_mark", "m", f"To the next mark: {marks}", mark(1, "after"), "Mark"),
        key("mark_before", "M", f"To the mark before: {marks}", mark(-1, "before")),
    ]


class RefuseStop(Command):
    """The command of the STOP key in `archo-tui replay`, which says that nothing was stopped."""

    id, key, where = "stop", "ctrl+x", EVERYWHERE
    help = "Stops nothing: this is a recording"

    def run(self, desk: Desk) -> None:
        desk.report_failure(Outcome(Code.REFUSED, NOTHING_STOPPED))


class StopConsole(Command):
    """The command of the STOP key in a replay that a console has begun: it stops the robot."""

    id, key, where, footer = "stop", "ctrl+x", EVERYWHERE, "STOP"
    help = "STOP the robot of the console that plays this, and go back to it"

    def run(self, desk: Desk) -> None:
        desk.leave()  # The STOP was sent as it was counted.


class CopySelection(Command):
    id, key, where = "copy_selection", "ctrl+c", EVERYWHERE
    help = "Copy the selection"

    def run(self, desk: Desk) -> None:
        if not desk.copy_selection():
            desk.show_message(f"Nothing is selected. Press {desk.view.key('quit')} to quit.")


class ShowRecordedAlarms(Command):
    id, key = "alarms", "A"
    help = "List the alarms of this moment"

    def __init__(self, player: Player) -> None:
        self._player = player

    def run(self, desk: Desk) -> None:
        if self._player.is_reading:
            desk.show_message("This moment is still being read.")
            return
        lines = [
            f"{alarm.priority.value}  {timeline(alarm)}\n   {alarm.text}"
            for alarm in desk.view.alarms
        ]
        desk.open(ShowText("Alarms", "\n\n".join(lines) or "No alarms."))


class QuitReplay(Quit):
    help = "Quit the replay"

    def run(self, desk: Desk) -> None:
        desk.leave()
