"""The command palette, Textual's own."""

from __future__ import annotations

from textual.command import CommandPalette
from textual.widgets import Input


class Palette(CommandPalette):
    """Its cursor stands still: a blinking one is traffic over SSH."""

    def on_mount(self) -> None:
        self.query_one(Input).cursor_blink = False
