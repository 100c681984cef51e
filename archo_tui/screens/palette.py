"""The command palette, Textual's own."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.command import CommandPalette
from textual.widgets import Input

from archo_tui.screens.dialog import Below


class Palette(CommandPalette):
    """Its cursor stands still: a blinking one is traffic over SSH."""

    def compose(self) -> ComposeResult:
        yield from super().compose()
        yield Below()

    def on_mount(self) -> None:
        self.query_one(Input).cursor_blink = False
