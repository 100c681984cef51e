"""The commands of the Graph panel."""

from __future__ import annotations

from collections.abc import Sequence

from archo_tui.commands.base import IN_PANEL, Command, Desk
from archo_tui.robot.state.graph import TOPIC
from archo_tui.widgets.graph_panel import GraphPanel


class ShowResource(Command):
    id, key, where, panel = "resource", "enter", IN_PANEL, GraphPanel
    help = (
        "Show the selected topic, its fields live, with plots and QoS; "
        "of a service or an action its full type and its nodes"
    )
    verbs = ("echo", "hz", "interface")

    def disabled_reason(self, desk: Desk) -> str:
        return "" if desk.main.graph.selected else "nothing is selected"

    def run(self, desk: Desk) -> None:
        from archo_tui.screens.text import ShowText

        row = desk.main.graph.selected
        assert row is not None
        if row.resource.kind == TOPIC:
            show_topic(desk, row.resource.name, row.resource.types)
        else:
            desk.open(ShowText(row.resource.name, row.details))


class ShowFrames(Command):
    id, verbs = "tf", ("tf",)
    help = "Show the transforms: parents, ages, rates, and what is wrong"

    def run(self, desk: Desk) -> None:
        from archo_tui.commands.lists import FrameList

        desk.open(FrameList(desk))


def show_topic(desk: Desk, name: str, types: Sequence[str]) -> None:
    """Open the dialog of a topic, with its live fields, plots, definition and QoS."""
    from archo_tui.commands.topic_dialog import TopicDialog

    desk.open(TopicDialog(desk, name, types))
