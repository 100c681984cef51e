"""The rows of the palette: every action, with further words by which it can be found."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from archo_tui.commands import graph, nodes, parameters
from archo_tui.commands.base import Command, Console
from archo_tui.errors import ArchoError
from archo_tui.robot.graph.parameter_values import parse
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.graph import Parameter
from archo_tui.screens.choose import Choice, Choose
from archo_tui.text.nodes import node_rows
from archo_tui.verbs.goals import Go
from archo_tui.verbs.names import topics_of
from archo_tui.verbs.parameters import Set
from archo_tui.verbs.verb import Values, Verb, run_when_ready
from archo_tui.widgets.screen_state import ScreenState

_NUMBER = re.compile(r"[-+]?\d+(\.\d*)?")
_FIRST = ("release", "go", "cancel", "stop")
_DUPLICATES = ("palette", "quit_everywhere")  # The same commands by another key.
_FIRST_THEMES = ("textual-dark", "textual-light", "high-contrast")  # Listed first.
_THEME_WORDS = "colours colors appearance dark night light bright day high contrast"
_SEARCH_WORDS = {
    "go": "drive move target send",
    "cancel": "abort call back",
    "cancel_all": "abort all",
    "continue": "resume proceed",
    "skip": "drop remove leave out next",
    "stop": "emergency halt brake",
    "give_up_stop": "forget",
    "release": "unlock resume clear reset stop",
    "send_goal": "action",
    "call": "request",
    "pub": "message topic send",
    "other_robot": "namespace switch robots restart",
    "keep_robot": "export write yaml",
    "describe_robot": "robot file new discover yaml",
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
        typed_choices: Callable[[str], Sequence[Choice]],
    ) -> None:
        super().__init__(title, list_choices())
        self._list_choices, self._typed_choices = list_choices, typed_choices
        self._second = 0.0  # The second of the last update.

    def _matches(self) -> Sequence[Choice]:
        return [*self._typed_choices(self._narrow.value), *super()._matches()]

    def show_view(self, view: ScreenState) -> None:
        """Update keys, values and reasons of the rows, which keep their places, once a second."""
        super().show_view(view)
        if view.second != self._second:
            self._second = view.second
            self.update_choices(self._list_choices())


def palette_choices(console: Console) -> list[Choice]:
    """Return all rows, those that can be done now first: of them release, go, cancel and STOP."""
    commands = {
        c.id: _command_choice(console, c) for c in console.registry if c.id not in _DUPLICATES
    }
    first = [commands.pop(name) for name in _FIRST if name in commands]
    screenshot = "screenshot export svg"
    rows = [
        *first,
        *commands.values(),
        Choice("Choose a theme", partial(_open_themes, console), console.theme, words=_THEME_WORDS),
        Choice("Save a picture of the screen", console.write_screenshot, words=screenshot),
        *_place_choices(console),
        *_node_choices(console),
        *_parameter_choices(console),
        *_topic_choices(console),
    ]
    return sorted(rows, key=lambda choice: bool(choice.reason))


def typed_choices(console: Console, typed: str) -> list[Choice]:
    """Return a row for a line that is a command by itself: `12 7`, or `set max_speed 0.2`."""
    return [*_goal_choices(console, typed), *_set_choices(console, typed)]


def _set_choices(console: Console, typed: str) -> list[Choice]:
    """Return a row that sets a parameter, as `Set motor_controller max_speed to 0.2`, or no row."""
    edit, verb = parameters.Edit(), Set()
    if all(command.id != edit.id for command in console.registry):
        return []  # A replay has no commands that act.
    try:
        values = verb.values(shlex.split(typed.removeprefix(f"{verb.id} ")))
        found = verb.find_parameter(console.station, values)
        reason = edit.disabled_reason(console) or _mistake(found, values["value"])
    except (ArchoError, ValueError):
        return []
    title = f"Set {found.node.lstrip('/')} {found.name} to {values['value']}"
    return [Choice(title, partial(_set, console, verb, values), "enter", reason)]


def _mistake(parameter: Parameter, typed: str) -> str:
    """Return why a parameter cannot have a typed value, or ""."""
    try:
        parse(parameter, typed)
    except ValueError as error:
        return str(error)
    return ""


async def _set(console: Console, verb: Set, values: Values) -> None:
    try:
        outcome = await run_when_ready(console.station, verb, values)
    except (ArchoError, ValueError) as error:
        outcome = Outcome(Code.MISUSE, f"not set: {error}")
    console.report_failure(outcome)


def _goal_choices(console: Console, typed: str) -> list[Choice]:
    """Return a row that sends typed numbers as goals, as `Go to shelf 7, 3`, or no row."""
    go = next((command for command in console.registry if command.id == "go"), None)
    kinds, panel = console.view.snapshot.file.goals, console.main.goal
    words = typed.split()
    if go is None or not kinds or not panel.takes_numbers or not words:
        return []
    if not all(_NUMBER.fullmatch(word) for word in words):
        return []
    reason = console.disabled_reason(go) or panel.refusal(typed)
    title = f"{kinds[0].title} {', '.join(words)}"
    return [Choice(title, partial(_send_numbers, console, go, typed), "enter", reason)]


def _place_choices(console: Console) -> Iterator[Choice]:
    """Yield a row for each place and each list of goals; none in a replay."""
    if all(command.id != "go" for command in console.registry):
        return
    places, station = console.station.places, console.station
    for go in (verb for verb in console.verbs.values() if isinstance(verb, Go)):
        for name in places.of(go.kind):
            act, words = partial(_drive_to, console, go, name), f"drive place {go.kind.title}"
            yield Choice(f"Go to {name}", act, "", go.refusal(station), words)
    for name, goals in places.lists.items():
        drive = console.verbs["go_list"]
        act, title = partial(_drive_to, console, drive, name), f"Drive {name} ({len(goals)} goals)"
        yield Choice(title, act, "", drive.refusal(station), "go list queue round")


async def _drive_to(console: Console, verb: Verb, name: str) -> None:
    """Send the goals of a place or a list, after the verb's question, or show why not."""
    station = console.station
    try:
        values = await verb.prepare(station, verb.values([name]))
    except (ArchoError, ValueError) as error:
        console.show_message(f"not sent: {error}")
        return
    work = console.run_verb(verb, values)
    if work is not None:
        await work


def _send_numbers(console: Console, go: Command, typed: str) -> None:
    """Send typed numbers as goals, or show as a notification why they cannot be sent now."""
    reason = console.disabled_reason(go) or console.main.goal.refusal(typed)
    if reason:
        console.show_message(f"not sent: {reason}")
    else:
        console.main.goal.send_numbers(typed)


def _command_choice(console: Console, command: Command) -> Choice:
    key, reason = console.view.key(command.id), console.disabled_reason(command)
    words = f"{command.id} {command.help} {_SEARCH_WORDS.get(command.id, '')}"
    act = partial(console.action_command, command.id)
    return Choice(command.title, act, key, reason, words)


def _parameter_choices(console: Console) -> Iterator[Choice]:
    edit = parameters.Edit()
    if all(command.id != edit.id for command in console.registry):
        return  # A replay has no commands that act.
    reason = edit.disabled_reason(console)
    for parameter in console.view.snapshot.parameters:
        title = f"Set {parameter.node.lstrip('/')} {parameter.name}"
        act = partial(_edit_parameter, console, parameter.node, parameter.name)
        yield Choice(title, act, text_of(parameter.value), reason, "parameter change")


def _edit_parameter(console: Console, node: str, name: str) -> None:
    """Open the dialog for a parameter with its present value, or show why nothing can be set."""
    edit, now = parameters.Edit(), console.view.snapshot.parameters
    found = next(
        (parameter for parameter in now if (parameter.node, parameter.name) == (node, name)), None
    )
    refused = edit.disabled_reason(console)
    if found is None or refused:
        console.show_message(refused or f"{node.lstrip('/')} {name} is not there any more")
    else:
        edit.open(console, found)


def _node_choices(console: Console) -> Iterator[Choice]:
    for row in node_rows(console.view):
        act = partial(nodes.open_node_dialog, console, row)
        yield Choice(f"Node {row.name.lstrip('/')}", act, words="info details")


def _topic_choices(console: Console) -> Iterator[Choice]:
    for topic in topics_of(console.view.snapshot):
        act = partial(graph.show_topic, console, topic.name, topic.types)
        yield Choice(f"Topic {topic.name}", act, words="echo plot inspect fields rate QoS")


def _open_themes(console: Console) -> None:
    themes = console.available_themes
    rows = [
        Choice(
            f"Theme {name}",
            partial(setattr, console, "theme", name),
            "now" if name == console.theme else "",
            words="dark night" if themes[name].dark else "light bright day",
        )
        for name in sorted(themes, key=lambda name: (name not in _FIRST_THEMES, name))
    ]
    console.open(Choose("Themes", rows))
