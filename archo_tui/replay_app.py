"""The app of a replay: the console on a recorded robot, which shows and does nothing."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from archo_tui.app import ArchoApp
from archo_tui.commands.base import Command
from archo_tui.commands.replay import replay_commands
from archo_tui.recordings.replay.station import RecordedStation
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screens.main import MainScreen
from archo_tui.terminal.app import start_worker
from archo_tui.widgets.time_line import TimeLine


class ReplayApp(ArchoApp):
    """The console's panels on a recorded robot, with a time line; no command acts on a robot."""

    def __init__(
        self, station: RecordedStation, keys: Mapping[str, str] | None = None, theme: str = ""
    ) -> None:
        self._player = station.player
        super().__init__(station, keys, theme)

    def commands(self, snapshot: Snapshot) -> tuple[Command, ...]:
        """Return the commands of a replay: its own, and the console's that act on no robot."""
        return replay_commands(self._player, super().commands(snapshot))

    def main_screen(self, snapshot: Snapshot) -> MainScreen:
        """Return a new main screen with the time line above the footer."""
        return MainScreen(snapshot, self.size, TimeLine(self._player))

    def on_mount(self) -> None:
        start_worker(self, partial(self._player.follow, self.update_screen), "play")

    def on_main_screen_broken(self, message: MainScreen.Broken) -> None:
        """Show an error of a panel as a notification, since a replay has no events for it."""
        message.prevent_default()
        self.notify(message.text, severity="error", markup=False)
