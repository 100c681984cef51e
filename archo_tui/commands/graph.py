"""The commands of the Graph panel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from archo_tui.commands.base import GRAPH, IN_PANEL, Command, Console
from archo_tui.commands.generic import AnyTopic
from archo_tui.daemon_threads import in_daemon
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.definitions import definitions_text
from archo_tui.robot.state.graph import TOPIC
from archo_tui.robot.state.topic import TopicView

if TYPE_CHECKING:
    from archo_tui.screens.topic import WatchedTopic


class ShowResource(Command):
    id, key, where, panel = "resource", "enter", IN_PANEL, GRAPH
    help = (
        "Show the selected topic, its fields live, with plots and QoS; "
        "of a service or an action its full type and its nodes"
    )
    verbs = ("echo", "hz", "interface")

    def disabled_reason(self, console: Console) -> str:
        return "" if console.main.graph.selected else "nothing is selected"

    def run(self, console: Console) -> None:
        from archo_tui.screens.text import ShowText

        row = console.main.graph.selected
        assert row is not None
        if row.resource.kind == TOPIC:
            show_topic(console, row.resource.name, row.resource.types, _step_in_graph)
        else:
            console.open(ShowText(row.resource.name, row.details))


class ShowFrames(Command):
    id, verbs = "tf", ("tf",)
    help = "Show the transforms: each frame with its parent, age and rate, and what is wrong"

    def run(self, console: Console) -> None:
        from archo_tui.screens.lists import FrameList

        console.open(FrameList(console.view, console.station.robot.listen_to_frames))


def _step_in_graph(console: Console, by: int) -> WatchedTopic | None:
    """Move Graph's cursor to the topic below (1) or above (-1), and return it; None if none."""
    row = console.main.graph.step(by, TOPIC)
    return None if row is None else _watched(console, row.resource.name, row.resource.types)


def show_topic(
    console: Console,
    name: str,
    types: Sequence[str],
    step: Callable[[Console, int], WatchedTopic | None] = lambda *_: None,
) -> None:
    """Open the dialog of a topic, with its live fields, plots, definition and QoS."""
    from archo_tui.screens.topic import TopicDialog

    console.open(TopicDialog(_watched(console, name, types), partial(step, console)))


def _watched(console: Console, name: str, types: Sequence[str]) -> WatchedTopic:
    from archo_tui.screens.topic import WatchedTopic

    def copy(view: TopicView) -> None:
        command = ros2_command.echo(name, view.type)
        console.copy(command)
        console.show_message(command, title="Copied the command")

    follow = partial(console.station.robot.follow_topic, name)
    commands = (command for command in console.registry if isinstance(command, AnyTopic))
    publish = next((partial(command.open_form, console, name) for command in commands), None)
    return WatchedTopic(name, follow, partial(in_daemon, definitions_text, types), copy, publish)
