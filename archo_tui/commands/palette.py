"""The command that opens the palette."""

from __future__ import annotations

from functools import partial

from archo_tui.commands.base import EVERYWHERE, Command, Console


class OpenPalette(Command):
    id, key = "palette", "ctrl+p"
    help = "Open the command palette: every command, parameter, node and topic, and the themes"
    where = EVERYWHERE

    def run(self, console: Console) -> None:
        from archo_tui.commands.palette_choices import CommandPalette, goal_choices, palette_choices

        if not any(isinstance(screen, CommandPalette) for screen in console.screens):
            rows, goals = partial(palette_choices, console), partial(goal_choices, console)
            console.open(CommandPalette("Commands", rows, goals))
