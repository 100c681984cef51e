"""What the console owes its terminal: driver, glyphs, themes, signals, a screen that may fail."""

from __future__ import annotations

import asyncio
import signal
import traceback
from collections.abc import Sequence
from typing import TYPE_CHECKING

from textual.app import App
from textual.driver import Driver
from textual.filter import LineFilter

from archo_tui.glyphs import Ascii, ascii_only
from archo_tui.leaving import Departure
from archo_tui.themes import HIGH_CONTRAST, THEMES, remember

if TYPE_CHECKING:
    from archo_tui.robot.client import Robot


class TerminalApp(App[None]):
    """Base of the app."""

    def __init__(self, robot: Robot, on_disconnect: str, theme: str) -> None:
        """`theme` is a name, or empty for the one that suits the terminal."""
        super().__init__()
        self.failure = ""  # the traceback that ended this screen
        self._departure = Departure(robot, on_disconnect, lambda code: self.exit(return_code=code))
        self._glyphs = [Ascii()] if ascii_only() else []
        for own in THEMES:
            self.register_theme(own)
        if theme or self.console.color_system == "standard":  # 16 colours: none in between
            self.theme = theme or HIGH_CONTRAST.name

    def get_driver_class(self) -> type[Driver]:
        chosen = super().get_driver_class()
        if chosen.__name__ != "LinuxDriver":  # a browser, a test, Windows
            return chosen
        from archo_tui.driver import SteadyDriver

        return SteadyDriver

    def get_line_filters(self) -> Sequence[LineFilter]:
        return [*super().get_line_filters(), *self._glyphs]

    def on_mount(self) -> None:
        if not self.is_headless:
            self._departure.on_signals()
        self.app_resume_signal.subscribe(self, lambda _: self.repaint())

    def watch_theme(self, before: str, theme: str) -> None:
        """Remember a theme that the operator chose."""

        async def write() -> None:
            try:
                await asyncio.to_thread(remember, theme)
            except OSError as error:
                self.notify(f"The theme is not remembered: {error.strerror}", markup=False)

        if self.screen_stack and self.screen.is_mounted and before != theme:
            self.run_worker(write(), group="theme", exclusive=True)

    def repaint(self) -> None:
        """Draw everything anew: the terminal may show something else."""
        if self.is_running and self.screen_stack:
            self.screen.refresh(layout=True)
            self.refresh()

    def hang_up(self) -> None:
        """The terminal is gone."""
        self._departure.begin(128 + signal.SIGHUP)

    def _handle_exception(self, error: Exception) -> None:
        """Textual's end of the screen, without its report: the next screen shows it."""
        if self.is_headless:
            super()._handle_exception(error)  # tests are told
            return
        if self._exit:  # what comes while the screen is taken down is of no account
            return
        self.failure = self.failure or "".join(traceback.format_exception(error))
        self._return_code = 1
        self._close_messages_no_wait()
