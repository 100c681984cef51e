"""The palette: every action, with further words by which it can be found."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from archo_tui.base.errors import ArchoError
from archo_tui.robot.messages.values import text_of
from archo_tui.screen.choose import Choice, Choose
from archo_tui.screen.commands import graph, nodes, parameters
from archo_tui.screen.commands.base import EVERYWHERE, Command, Desk, file_writer
from archo_tui.screen.dialog import AskPath
from archo_tui.screen.widgets.panel import ScreenState
from archo_tui.text.nodes import node_rows
from archo_tui.verbs.goals import Go
from archo_tui.verbs.names import topics_of
from archo_tui.verbs.verb import Verb


class OpenPalette(Command):
    in_replay = True
    id, key = "palette", "ctrl+p"
    help = "Open the command palette: every command, parameter, node and topic"
    where = EVERYWHERE

    def run(self, desk: Desk) -> None:
        if not any(isinstance(screen, CommandPalette) for screen in desk.screen_stack):
            rows = partial(palette_choices, desk)
            desk.open(CommandPalette("Commands", rows))


_FIRST = ("release", "go", "cancel", "stop")
_DUPLICATES = ("palette", "quit_everywhere")  # The same commands by another key.
_PICTURE = "Save a picture of the screen"
_FIRST_THEMES = ("textual-dark", "textual-light", "high-contrast")  # Listed first.
_THEME_WORDS = "colours colors appearance dark night light bright day high contrast"
_SEARCH_WORDS = {
    "go": "drive move target send",
    "cancel": "abort call back",
    "cancel_all": "abort all goals",
    "continue": "resume proceed",
    "skip": "drop remove leave out next",
    "stop": "emergency halt brake",
    "give_up_stop": "forget",
    "release": "unlock resume clear reset stop",
    "send_goal": "action",
    "call": "request",
    "pub": "message topic send",
    "describe_robot": "robot file save export new discover yaml",
    "save_place": "pose waypoint",
    "save_queue": "list goals",
    "ack": "confirm seen",
    "diagnostics": "parts health hardware",
    "alarms": "warnings errors problems",
    "edit": "set change value parameter",
    "restore": "default reset",
    "switch": "toggle flag",
    "only_changed": "difference differ diff modified",
    "filter": "find search",
    "all_parameters": "hidden own use_sim_time ros every standard",
    "resource": "interface message info type definition",
    "tf": "tf2 frames tree coordinate",
    "undo": "back revert",
    "save": "export write dump yaml",
    "load": "import open read yaml",
    "start_stop": "kill restart launch",
    "copy": "duplicate another instance",
    "restart": "reload saved again",
    "details": "info inspect traceback crash",
    "level": "severity debug warn error",
    "search": "find filter grep",
    "copy_command": "clipboard yank",
    "full_screen": "log logs maximize zoom",
    "save_events": "export log write",
    "whole_event": "open details",
    "history": "plot chart trend",
    "shorter": "zoom in",
    "longer": "zoom out",
    "help": "shortcuts bindings here",
    "help_everywhere": "help shortcuts bindings manual",
    "recordings": "replay black box bags delete",
    "keep": "record recording rosbag bag",
    "quiet_alarms": "mute silence sound beep",
    "suspend": "background shell",
    "quit": "exit leave close end",
}


class CommandPalette(Choose):
    """The command palette: commands, nodes, parameters and topics in one list."""

    empty_text = "no command matches"

    def __init__(
        self,
        title: str,
        # Called now, and each second for keys and reasons.
        list_choices: Callable[[], Sequence[Choice]],
    ) -> None:
        super().__init__(title, list_choices())
        self._list_choices = list_choices
        self._second = 0.0  # The second of the last update.

    def show_view(self, view: ScreenState) -> None:
        """Update keys, values and reasons of the rows, which keep their places, once a second."""
        super().show_view(view)
        if view.second != self._second:
            self._second = view.second
            self.update_choices(self._list_choices())


def palette_choices(desk: Desk) -> list[Choice]:
    """Return all rows, those that can be done now first: of them release, go, cancel and STOP."""
    listed = [c for c in desk.registry if c.is_listed and c.id not in _DUPLICATES]
    commands = {c.id: _command_choice(desk, c) for c in listed}
    first = [commands.pop(name) for name in _FIRST if name in commands]
    screenshot = "screenshot export svg"
    rows = [
        *first,
        *commands.values(),
        Choice("Choose a theme", partial(_open_themes, desk), desk.theme, words=_THEME_WORDS),
        Choice(_PICTURE, partial(_save_picture, desk), words=screenshot),
        *_place_choices(desk),
        *_node_choices(desk),
        *_parameter_choices(desk),
        *_topic_choices(desk),
    ]
    return sorted(rows, key=lambda choice: bool(choice.reason))


async def _save_picture(desk: Desk) -> None:
    """Ask where to save the screen as SVG, as it is drawn once the palette has gone."""
    drawn = asyncio.Event()
    with desk.opening():
        desk.call_after_refresh(drawn.set)
        await drawn.wait()
        write = file_writer(desk, desk.export_screenshot(), "save a picture")
    desk.open(AskPath(_PICTURE, "SVG file", "archo.svg", write, writes=True))


def _place_choices(desk: Desk) -> Iterator[Choice]:
    """Yield a row for each place and each list of goals; none in a replay."""
    if not any(command.id == "go" and command.is_listed for command in desk.registry):
        return
    places, station = desk.station.places, desk.station
    for go in (verb for verb in desk.verbs.values() if isinstance(verb, Go)):
        for name in places.of(go.kind):
            act, words = partial(_drive_to, desk, go, name), f"drive place {go.kind.title}"
            yield Choice(f"Go to {name}", act, "", go.refusal(station), words)
    for name, goals in places.lists.items():
        drive = desk.verbs["go_list"]
        act, title = partial(_drive_to, desk, drive, name), f"Drive {name} ({len(goals)} goals)"
        yield Choice(title, act, "", drive.refusal(station), "go list queue round")


async def _drive_to(desk: Desk, verb: Verb, name: str) -> None:
    """Send the goals of a place or a list, after the verb's question, or show why not."""
    station = desk.station
    try:
        values = await verb.prepare(station, verb.values([name]))
    except (ArchoError, ValueError) as error:
        desk.show_message(f"not sent: {error}")
        return
    work = desk.run_verb(verb, values)
    if work is not None:
        await work


def _command_choice(desk: Desk, command: Command) -> Choice:
    key, reason = desk.view.key(command.id), command.disabled_reason(desk)
    words = f"{command.id} {command.help} {_SEARCH_WORDS.get(command.id, '')}"
    act = partial(desk.action_command, command.id)
    return Choice(command.title, act, key, reason, words)


def _parameter_choices(desk: Desk) -> Iterator[Choice]:
    edit = parameters.Edit()
    if all(command.id != edit.id for command in desk.registry):
        return  # A replay has no commands that act.
    reason = edit.disabled_reason(desk)
    for parameter in desk.view.snapshot.parameters:
        title = f"Set {parameter.node.lstrip('/')} {parameter.name}"
        act = partial(_edit_parameter, desk, parameter.node, parameter.name)
        yield Choice(title, act, text_of(parameter.value), reason, "parameter change")


def _edit_parameter(desk: Desk, node: str, name: str) -> None:
    """Open the dialog for a parameter with its present value, or show why nothing can be set."""
    edit, now = parameters.Edit(), desk.view.snapshot.parameters
    found = next(
        (parameter for parameter in now if (parameter.node, parameter.name) == (node, name)), None
    )
    refused = edit.disabled_reason(desk)
    if found is None or refused:
        desk.show_message(refused or f"{node.lstrip('/')} {name} is not there any more")
    else:
        edit.open(desk, found)


def _node_choices(desk: Desk) -> Iterator[Choice]:
    for row in node_rows(desk.view):
        act = partial(nodes.open_node_dialog, desk, row.name)
        yield Choice(f"Node {row.name.lstrip('/')}", act, words="info details")


def _topic_choices(desk: Desk) -> Iterator[Choice]:
    for topic in topics_of(desk.view.snapshot):
        act = partial(graph.show_topic, desk, topic.name, topic.types)
        yield Choice(f"Topic {topic.name}", act, words="echo plot inspect fields rate QoS")


def _open_themes(desk: Desk) -> None:
    themes = desk.available_themes
    rows = [
        Choice(
            f"Theme {name}",
            partial(setattr, desk, "theme", name),
            "now" if name == desk.theme else "",
            words="dark night" if themes[name].dark else "light bright day",
        )
        for name in sorted(themes, key=lambda name: (name not in _FIRST_THEMES, name))
    ]
    desk.open(Choose("Themes", rows))
