"""The replay inside of a live console: commands act on the recording, only STOP on the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

from textual.geometry import Size
from textual.screen import Screen
from textual.theme import Theme

from archo_tui.commands.base import EVERYWHERE, Answers, Command, Console, Work
from archo_tui.commands.footer import blocked_commands, keys_of_footer
from archo_tui.commands.keymap import readable_keys
from archo_tui.commands.replay import CopySelection, read_only_commands
from archo_tui.recordings.replay.player import Player
from archo_tui.recordings.replay.station import RecordedStation
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screens.dismissable import Dismissable
from archo_tui.screens.replay import ReplayScreen
from archo_tui.station.station import Station
from archo_tui.terminal.stop_marks import InputTime
from archo_tui.verbs import verbs
from archo_tui.verbs.verb import Values, Verb
from archo_tui.widgets.screen_state import ScreenState

_LIVE_ONLY = ("suspend",)  # It asks about the robot's goal, which is another one in the recording.


class ReplayConsole:
    """The console of a recording, shown over the live console. Event loop only.

    Dialogs, notifications, the theme and the clipboard are those of the live console; station,
    verbs, view, typed and used those of the recording. STOP is passed on to the live console.
    """

    def __init__(
        self,
        live: Console,
        player: Player,
        commands: tuple[Command, ...],
        keys: Mapping[str, str],
        size: Size,
    ) -> None:
        self._live = live
        self.station: Station = RecordedStation(player, live.station.clock)
        snapshot = self.station.robot.snapshot
        self.verbs: Mapping[str, Verb] = verbs(snapshot.file, snapshot.forms)
        self.typed: dict[str, dict[str, str]] = {}
        self.used = snapshot.file
        shown = [c for c in read_only_commands(player, commands) if c.id not in _LIVE_ONLY]
        stop = next(command for command in live.registry if command.id == "stop")
        own = BackToLive(), StopLive(live, stop), CopyFromReplay(), QuitBoth(live)
        self.registry: Sequence[Command] = (*own[:2], *shown, *own[2:])
        self.keys = {c.id: keys.get(c.id, c.key) for c in self.registry}  # By the command's id.
        self.shown_keys = readable_keys(self.keys)
        self.view = ScreenState(**vars(self.station.view), keys=self.shown_keys)
        self.main = ReplayScreen(snapshot, size, player, self.update_screen)

    def update_screen(self) -> None:
        """Show the state at the player's position on the screen and in the dialogs over it."""
        self.station.refresh()
        self.view = ScreenState(**vars(self.station.view), keys=self.shown_keys)
        screens = self.screens
        if not (self.main in screens and self.main.is_mounted):
            return
        self.view = replace(self.view, blocked=blocked_commands(self))
        self.main.show(self.view, keys_of_footer(self))
        for dialog in screens[screens.index(self.main) + 1 :]:
            if isinstance(dialog, Dismissable) and dialog.is_mounted:
                dialog.update_view(self.view)

    @property
    def repeated(self) -> bool:
        return self._live.repeated

    @property
    def input(self) -> InputTime | None:
        return self._live.input

    @property
    def theme(self) -> str:
        return self._live.theme

    @theme.setter
    def theme(self, name: str) -> None:
        self._live.theme = name

    @property
    def screen(self) -> Screen[Any]:
        return self._live.screen

    @property
    def screens(self) -> Sequence[Screen[Any]]:
        return self._live.screens

    @property
    def is_stuck(self) -> bool:
        return self._live.is_stuck

    @property
    def available_themes(self) -> Mapping[str, Theme]:
        return self._live.available_themes

    def disabled_reason(self, command: Command) -> str:
        return command.disabled_reason(self)

    def open(self, dialog: Screen[Any]) -> None:
        self._live.open(dialog)

    def begin_replay(self, player: Player) -> None:
        """Do nothing: a replay lists no recordings."""

    def end_replay(self) -> None:
        self._live.end_replay()

    def opening(self) -> AbstractContextManager[None]:
        return self._live.opening()

    def run_verb(self, verb: Verb, values: Values) -> Work | None:
        """Send nothing, say so in a notification, and return None."""
        self.report_failure(Outcome(Code.REFUSED, f"REPLAY: {verb.id} was not sent"))
        return None

    def confirm(self, title: str, question: str, safe: str, answers: Answers) -> None:
        self._live.confirm(title, question, safe, answers)

    def report_failure(self, outcome: Outcome) -> None:
        """Show the outcome of a command that failed, with the title `Replay`; else do nothing."""
        if not outcome.ok:  # As the live console reports it, it would be about the robot.
            self._live.show_message(outcome.text, "Replay")

    def drop_following_keys(self, why: str) -> None:
        self._live.drop_following_keys(why)

    def show_message(self, text: str, title: str = "") -> None:
        self._live.show_message(text, title)

    def copy(self, text: str) -> None:
        """Put a text on the clipboard of the terminal."""
        self._live.copy(text)

    def copy_selection(self) -> bool:
        """Copy the selected text; return False if nothing is selected."""
        return self._live.copy_selection()

    def write_screenshot(self) -> None:
        """Save the screen as SVG, once the palette that asked for it is gone."""
        self._live.write_screenshot()

    def action_command(self, name: str) -> None:
        """Run a command of the replay by its id; `stop` runs the live console's STOP."""
        self._live.action_command(name)

    def action_suspend_process(self) -> None:
        """Do nothing: only the live console can be suspended."""

    def leave(self) -> None:
        self.end_replay()


class BackToLive(Command):
    id, key, footer = "quit", "q", "Live robot"
    help = "Back to the live robot, which went on meanwhile"

    def run(self, console: Console) -> None:
        console.end_replay()


class StopLive(Command):
    """The STOP command of the replay, which runs that of the live console."""

    id, where = "stop", EVERYWHERE

    def __init__(self, live: Console, stop: Command) -> None:
        self._live, self._stop = live, stop
        self.key, self.footer = stop.key, f"{stop.footer} live"
        self.help = f"On the live robot: {stop.help}"

    def disabled_reason(self, console: Console) -> str:
        return self._live.disabled_reason(self._stop)

    def run(self, console: Console) -> None:
        self._live.action_command("stop")


class CopyFromReplay(CopySelection):
    def run(self, console: Console) -> None:
        if not console.copy_selection():
            key = console.view.key("quit")
            console.show_message(f"REPLAY: nothing was cancelled. Press {key} for the live robot.")


class QuitBoth(Command):
    id, key, where = "quit_everywhere", "ctrl+q", EVERYWHERE
    help = "Leave the replay and quit the live console, as there"

    def __init__(self, live: Console) -> None:
        self._live = live

    def run(self, console: Console) -> None:
        console.end_replay()
        self._live.action_command(self.id)
