"""The desk of a replay, and its commands: those that change nothing, and the time line's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from archo_tui.commands import registry
from archo_tui.commands.base import (
    EVERYWHERE,
    IN_PANEL,
    NOT_TYPING,
    Command,
    ConsoleApp,
    Desk,
    PanelKey,
    Work,
)
from archo_tui.commands.console import Quit
from archo_tui.recordings.replay.player import Player
from archo_tui.recordings.replay.station import NOTHING_STOPPED, RecordedStation
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot_file.model import RobotFile
from archo_tui.screens.replay import ReplayScreen
from archo_tui.screens.text import ShowText
from archo_tui.text.alarm import timeline
from archo_tui.verbs.verb import Values, Verb
from archo_tui.widgets.time_line import TimeLine

# The console's commands that change nothing; a replay has no others of them.
_HARMLESS = frozenset(
    (
        *("only_changed", "all_parameters", "filter", "save", "details", "level", "search"),
        *("copy_command", "full_screen", "whole_event", "save_events", "history", "shorter"),
        *("longer", "resource", "diagnostics", "help", "help_everywhere", "palette", "suspend"),
    )
)


_LIVE_ONLY = ("suspend",)  # It asks about the robot's goal, which is another one in the recording.


def replay_commands(player: Player, verbs: Mapping[str, Verb]) -> Sequence[Command]:
    """Return the commands of `archo-tui replay`: the read-only ones, and four of its own."""
    return (
        *_read_only_commands(player, verbs),
        RefuseStop(),
        CopySelection(),
        QuitReplay(),
        QuitReplayEverywhere(),
    )


def _commands_over_live(
    live: ConsoleApp, player: Player, verbs: Mapping[str, Verb]
) -> Sequence[Command]:
    """Return the commands of a replay over the live console: the read-only ones, and its own."""
    shown = [c for c in _read_only_commands(player, verbs) if c.id not in _LIVE_ONLY]
    stop = next(command for command in live.registry if command.id == "stop")
    return BackToLive(), StopLive(live, stop), *shown, CopyFromReplay(), QuitBoth()


def _read_only_commands(player: Player, verbs: Mapping[str, Verb]) -> Sequence[Command]:
    """Return the time line's commands, a list of recorded alarms, and all that change nothing.

    The keys of those that act say that nothing was sent.
    """
    commands = registry(player.file, verbs)
    panels = [command for command in commands if isinstance(command, PanelKey)]
    panels[0].footer_key = f"1-{TimeLine.number}"
    shown = [c for c in commands if isinstance(c, PanelKey) or c.id in _HARMLESS]
    own = (
        Play(player),
        StepSeconds(player, "back", "left", -1.0),
        StepSeconds(player, "on", "right", 1.0, "1 s"),
        StepSeconds(player, "back_ten", "shift+left", -10.0),
        StepSeconds(player, "on_ten", "shift+right", 10.0),
        GoToBegin(player),
        GoToEnd(player),
        StepMessage(player, "message_before", "comma", -1),
        StepMessage(player, "message_after", "full_stop", 1),
        ChangeSpeed(player, "slower", "left_curly_bracket", -1),
        ChangeSpeed(player, "faster", "right_curly_bracket", 1, "Speed"),
        StepMark(player, "next_mark", "m", 1, "Mark"),
        StepMark(player, "mark_before", "M", -1),
        *shown,
        TimeLineKey(player.file),
        ShowRecordedAlarms(player),
    )
    used = {command.key for command in own}
    acting = (c for c in commands if c.verbs and c.key and c.where == NOT_TYPING)
    return *own, *(NotSent(c) for c in acting if c.key not in used and c not in shown)


class NotSent(Command):
    """The key of a command that acts on a robot, which says in a replay that nothing was sent."""

    is_listed = False

    def __init__(self, command: Command) -> None:
        self.id, self.key, self.help = command.id, command.key, command.help

    def run(self, desk: Desk) -> None:
        key = desk.view.key("quit")
        where = "for the live robot" if desk is not desk.live else "to leave the replay"
        desk.show_message(f"REPLAY: {self.id} was not sent: press {key} {where}.")


class ReplayDesk(Desk):
    """The desk of a recording over the live console, whose STOP still stops the robot."""

    def __init__(self, live: ConsoleApp, player: Player) -> None:
        station = RecordedStation(player, live.station.clock)
        screen = ReplayScreen(station.robot.snapshot, live.size, player, self.update_screen)
        self.set_up(live, station, partial(_commands_over_live, live, player), live.keys, screen)

    def run_verb(self, verb: Verb, values: Values) -> None:
        """Send nothing, and say so."""
        self.report_failure(Outcome(Code.REFUSED, f"REPLAY: {verb.id} was not sent"))

    def report_failure(self, outcome: Outcome) -> None:
        """Show the outcome of a command that failed, with the title `Replay`; else do nothing."""
        if not outcome.ok:  # As the live console reports it, it would be about the robot.
            self.show_message(outcome.text, "Replay")


class TimeLineKey(PanelKey):
    def __init__(self, robot: RobotFile) -> None:
        super().__init__(TimeLine, robot)
        self.id = "time_line"


class _TimeLineCommand(Command):
    where, panel = IN_PANEL, TimeLine

    def __init__(self, player: Player) -> None:
        self.player = player

    def run(self, desk: Desk) -> Work | None:
        self.move(desk)
        desk.update_screen()
        return None

    def move(self, desk: Desk) -> None:
        """Change the position, speed or playing state of the player; a subclass must define it."""
        raise NotImplementedError


class Play(_TimeLineCommand):
    id, key, footer = "play", "space", "Play"
    help = "Play, or pause"

    def move(self, desk: Desk) -> None:
        self.player.play(on=not self.player.is_playing)


class StepSeconds(_TimeLineCommand):
    def __init__(
        self, player: Player, name: str, key: str, seconds: float, footer: str = ""
    ) -> None:
        super().__init__(player)
        self.id, self.key, self._seconds, self.footer = name, key, seconds, footer
        self.footer_key = "←→" if footer else ""
        self.help = f"{abs(seconds):g} s {'back' if seconds < 0 else 'on'}"

    def move(self, desk: Desk) -> None:
        self.player.go_to(self.player.position + self._seconds)


class GoToBegin(_TimeLineCommand):
    id, key = "begin", "home"
    help = "To the beginning of the recording"

    def move(self, desk: Desk) -> None:
        self.player.go_to(self.player.start)


class GoToEnd(_TimeLineCommand):
    id, key = "end", "end"
    help = "To the end of the recording"

    def move(self, desk: Desk) -> None:
        self.player.play(on=False)
        self.player.go_to(self.player.end)


class StepMessage(_TimeLineCommand):
    def __init__(self, player: Player, name: str, key: str, step: int) -> None:
        super().__init__(player)
        self.id, self.key, self._step = name, key, step
        self.help = f"To the {'next message' if step > 0 else 'message before'}"

    def move(self, desk: Desk) -> None:
        self.player.step_message(self._step)


class ChangeSpeed(_TimeLineCommand):
    def __init__(self, player: Player, name: str, key: str, step: int, footer: str = "") -> None:
        super().__init__(player)
        self.id, self.key, self._step, self.footer = name, key, step, footer
        self.footer_key = "{}" if footer else ""
        self.help = f"Play {name}: 0.25 to 16 times as fast as it was"

    def move(self, desk: Desk) -> None:
        self.player.change_speed(self._step)


class StepMark(_TimeLineCommand):
    def __init__(self, player: Player, name: str, key: str, step: int, footer: str = "") -> None:
        super().__init__(player)
        self.id, self.key, self._step, self.footer = name, key, step, footer
        where = "next mark" if step > 0 else "mark before"
        self.help = f"To the {where}: an alarm, a command, the end of a goal"

    def move(self, desk: Desk) -> None:
        if self.player.step_mark(self._step) is None:
            desk.show_message(
                f"There is no mark {'after' if self._step > 0 else 'before'} this moment."
            )


class RefuseStop(Command):
    """The command of the STOP key in `archo-tui replay`, which says that nothing was stopped."""

    id, key, where = "stop", "ctrl+x", EVERYWHERE
    help = "Stops nothing: this is a recording"

    def run(self, desk: Desk) -> None:
        desk.report_failure(Outcome(Code.REFUSED, NOTHING_STOPPED))


class CopySelection(Command):
    id, key, where = "copy_selection", "ctrl+c", EVERYWHERE
    help = "Copy the selection"

    def run(self, desk: Desk) -> None:
        if not desk.live.copy_selection():
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
        desk.live.open(ShowText("Alarms", "\n\n".join(lines) or "No alarms."))


class QuitReplay(Quit):
    help = "Quit the replay"

    def run(self, desk: Desk) -> None:
        desk.live.leave()


class QuitReplayEverywhere(QuitReplay):
    id, key, footer = "quit_everywhere", "ctrl+q", ""
    help = "Quit the replay, also while typing"
    where = EVERYWHERE


class BackToLive(Command):
    id, key, footer = "quit", "q", "Live robot"
    help = "Back to the live robot, which went on meanwhile"

    def run(self, desk: Desk) -> None:
        desk.live.end_replay()


class StopLive(Command):
    """The STOP command of the replay, which runs that of the live console."""

    id, where = "stop", EVERYWHERE

    def __init__(self, live: Desk, stop: Command) -> None:
        self._live, self._stop = live, stop
        self.key, self.footer = stop.key, f"{stop.footer} live"
        self.help = f"On the live robot: {stop.help}"

    def disabled_reason(self, desk: Desk) -> str:
        return self._stop.disabled_reason(self._live)

    def run(self, desk: Desk) -> None:
        desk.live.action_command("stop")


class CopyFromReplay(CopySelection):
    def run(self, desk: Desk) -> None:
        if not desk.live.copy_selection():
            key = desk.view.key("quit")
            desk.show_message(f"REPLAY: nothing was cancelled. Press {key} for the live robot.")


class QuitBoth(Command):
    id, key, where = "quit_everywhere", "ctrl+q", EVERYWHERE
    help = "Leave the replay and quit the live console, as there"

    def run(self, desk: Desk) -> None:
        desk.live.end_replay()
        desk.live.action_command(self.id)
