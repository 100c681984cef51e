"""The commands of the Graph panel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from archo_tui.commands.base import IN_PANEL, Command, Desk
from archo_tui.commands.generic import AnyTopic
from archo_tui.daemon_threads import in_daemon
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.definitions import definitions_text
from archo_tui.robot.state.graph import TOPIC
from archo_tui.robot.state.topic import TopicView
from archo_tui.widgets.graph_panel import GraphPanel

if TYPE_CHECKING:
    from archo_tui.screens.topic import WatchedTopic


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
            show_topic(desk, row.resource.name, row.resource.types, _step_in_graph)
        else:
            desk.live.open(ShowText(row.resource.name, row.details))


class ShowFrames(Command):
    id, verbs = "tf", ("tf",)
    help = "Show the transforms: parents, ages, rates, and what is wrong"

    def run(self, desk: Desk) -> None:
        from archo_tui.screens.lists import FrameList

        desk.live.open(FrameList(desk.view, desk.station.robot.listen_to_frames))


def _step_in_graph(desk: Desk, by: int) -> WatchedTopic | None:
    """Move Graph's cursor to the topic below (1) or above (-1), and return it; None if none."""
    row = desk.main.graph.step(by, TOPIC)
    return None if row is None else _watched(desk, row.resource.name, row.resource.types)


def show_topic(
    desk: Desk,
    name: str,
    types: Sequence[str],
    step: Callable[[Desk, int], WatchedTopic | None] = lambda *_: None,
) -> None:
    """Open the dialog of a topic, with its live fields, plots, definition and QoS."""
    from archo_tui.screens.topic import TopicDialog

    desk.live.open(TopicDialog(_watched(desk, name, types), partial(step, desk)))


def _watched(desk: Desk, name: str, types: Sequence[str]) -> WatchedTopic:
    from archo_tui.screens.topic import WatchedTopic

    def copy(view: TopicView) -> None:
        command = ros2_command.echo(name, view.type)
        desk.live.copy_to_clipboard(command)
        desk.show_message(command, title="Copied the command")

    follow = partial(desk.station.robot.follow_topic, name)
    commands = (command for command in desk.registry if isinstance(command, AnyTopic))
    publish = next((partial(command.open_form, desk, name) for command in commands), None)
    return WatchedTopic(name, follow, partial(in_daemon, definitions_text, types), copy, publish)
