"""The screen of a replay inside of the live console, which goes on meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from textual.app import ComposeResult
from textual.content import Content
from textual.geometry import Size

from archo_tui.recordings.replay.player import Player
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screens.dismissable import Dismissable
from archo_tui.screens.main import MainScreen
from archo_tui.terminal.app import start_worker
from archo_tui.widgets.line import Line
from archo_tui.widgets.live_line import live_line
from archo_tui.widgets.screen_state import ScreenState
from archo_tui.widgets.time_line import TimeLine


class ReplayScreen(MainScreen, Dismissable[None]):
    """The panels of a recorded robot, with a line above them that tells what the live robot does.

    The player is closed with the screen.
    """

    def __init__(
        self, snapshot: Snapshot, size: Size, player: Player, update: Callable[[], None]
    ) -> None:
        super().__init__(snapshot, size, TimeLine(player))
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
