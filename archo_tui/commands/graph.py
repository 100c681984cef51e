"""The commands of the Graph panel."""

from __future__ import annotations

from archo_tui.commands.base import GRAPH, IN_PANEL, Command, Console


class ShowResource(Command):
    id, key, where, panel = "resource", "enter", IN_PANEL, GRAPH
    help = "Show the selected topic, service or action: its full type and all its nodes"

    def disabled_reason(self, console: Console) -> str:
        return "" if console.main.graph.selected else "nothing is selected"

    def run(self, console: Console) -> None:
        from archo_tui.screens.text import ShowText

        row = console.main.graph.selected
        assert row is not None
        console.open(ShowText(row.resource.name, row.details))
