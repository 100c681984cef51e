"""The command that opens the palette."""

from __future__ import annotations

from functools import partial

from archo_tui.commands.base import EVERYWHERE, Command, Desk


class OpenPalette(Command):
    id, key = "palette", "ctrl+p"
    help = "Open the command palette: every command, parameter, node and topic"
    where = EVERYWHERE

    def run(self, desk: Desk) -> None:
        from archo_tui.commands import palette_choices as palette

        if not any(isinstance(screen, palette.CommandPalette) for screen in desk.screen_stack):
            rows = partial(palette.palette_choices, desk)
            desk.open(palette.CommandPalette("Commands", rows))
