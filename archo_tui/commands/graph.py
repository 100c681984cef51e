"""The commands of the Graph panel."""

from __future__ import annotations

from functools import partial

from archo_tui.commands.base import GRAPH, IN_PANEL, Command, Console
from archo_tui.daemon_threads import in_daemon
from archo_tui.robot.interface_text import definitions_text
from archo_tui.robot.state import TOPIC


class ShowResource(Command):
    id, key, where, panel = "resource", "enter", IN_PANEL, GRAPH
    help = "Show the selected topic, service or action: its full type, its nodes, and their QoS"
    verbs = ("echo", "hz", "interface")

    def disabled_reason(self, console: Console) -> str:
        return "" if console.main.graph.selected else "nothing is selected"

    def run(self, console: Console) -> None:
        from archo_tui.screens.text import ShowText
        from archo_tui.screens.topic import TopicDialog

        row = console.main.graph.selected
        assert row is not None
        if row.resource.kind == TOPIC:
            ask = partial(console.station.robot.topic_info, row.resource.name)
            read_type = partial(in_daemon, definitions_text, row.resource.types)
            console.open(TopicDialog(row.resource.name, row.details, ask, read_type))
        else:
            console.open(ShowText(row.resource.name, row.details))
