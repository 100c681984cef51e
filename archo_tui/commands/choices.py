"""What the palette lists: everything that can be done, by the words that people have for it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from archo_tui.commands import nodes, parameters
from archo_tui.commands.base import Command, Console
from archo_tui.robot.values import text_of
from archo_tui.screens.choose import Choice, Choose
from archo_tui.station.station import View
from archo_tui.words.nodes import node_rows

_FIRST = ("go", "cancel", "stop")
_TWINS = ("palette", "help_everywhere", "quit_everywhere")  # the same by another key
_KNOWN = ("textual-dark", "textual-light", "high-contrast")  # themes that stand first
_WORDS = {
    "go": "drive move target send",
    "cancel": "abort call back",
    "cancel_all": "abort all",
    "continue": "resume proceed",
    "skip": "drop remove next",
    "stop": "emergency halt brake",
    "give_up_stop": "forget",
    "release": "unlock resume clear reset stop",
    "send_goal": "action",
    "call": "request",
    "keep_robot": "export write yaml",
    "ack": "confirm seen",
    "alarms": "warnings errors problems",
    "edit": "set change value parameter",
    "restore": "default reset",
    "switch": "toggle flag",
    "only_changed": "difference diff modified",
    "filter": "find search",
    "ros_own": "hidden own use_sim_time",
    "resource": "interface message info",
    "undo": "back revert",
    "save": "export write dump yaml",
    "load": "import open read yaml",
    "start_stop": "kill restart launch",
    "copy": "duplicate another instance",
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
    "help": "keys shortcuts bindings manual",
    "recordings": "replay black box bags delete",
    "keep": "record recording rosbag bag",
    "quiet_alarms": "mute sound beep",
    "suspend": "background shell",
    "quit": "exit leave close end",
}


class Commands(Choose):
    """The palette."""

    nothing = "no command matches"

    def __init__(self, title: str, list_choices: Callable[[], Sequence[Choice]]) -> None:
        super().__init__(title, list_choices())
        self._list_choices = list_choices
        self._second = 0.0  # when its rows were brought up to date

    def follow(self, view: View) -> None:
        """Bring keys, values and reasons up to date once a second; the rows keep their places."""
        super().follow(view)
        if view.second != self._second:
            self._second = view.second
            self.renew(self._list_choices())


def choices(console: Console) -> list[Choice]:
    """Go, cancel and STOP; what else can be done now; what cannot; what can be set or seen."""
    commands = {c.id: _choice(console, c) for c in console.registry if c.id not in _TWINS}
    first = [commands.pop(name) for name in _FIRST if name in commands]
    return [
        *first,
        *sorted(commands.values(), key=lambda choice: bool(choice.reason)),
        *_nodes(console),
        *_parameters(console),
        *_themes(console),
        Choice("Save a picture of the screen", console.picture, words="screenshot export svg"),
    ]


def _choice(console: Console, command: Command) -> Choice:
    title = re.split("[:;]", command.help)[0]
    title = title[0].upper() + title[1:]
    key, reason = console.view.key(command.id), console.blocked(command)
    words = f"{command.id} {command.help} {_WORDS.get(command.id, '')}"
    act = partial(console.action_command, command.id)
    return Choice(title, act, key, reason, words)


def _parameters(console: Console) -> Iterator[Choice]:
    edit = parameters.Edit()
    if all(command.id != edit.id for command in console.registry):
        return  # a replay: whatever acts is not there
    reason = edit.blocked(console)
    for one in console.view.snapshot.parameters:
        title = f"Set {one.node.lstrip('/')} {one.name}"
        act = partial(_edit, console, one.node, one.name)
        yield Choice(title, act, text_of(one.value), reason, "parameter change")


def _edit(console: Console, node: str, name: str) -> None:
    """The parameter as it is now: the list may be open for long."""
    edit, now = parameters.Edit(), console.view.snapshot.parameters
    found = next((one for one in now if (one.node, one.name) == (node, name)), None)
    refused = edit.blocked(console)
    if found is None or refused:
        console.say(refused or f"{node.lstrip('/')} {name} is not there any more")
    else:
        edit.open(console, found)


def _nodes(console: Console) -> Iterator[Choice]:
    for row in node_rows(console.view):
        act = partial(nodes.show, console, row)
        yield Choice(f"Node {row.name.lstrip('/')}", act, words="info details")


def _themes(console: Console) -> Iterator[Choice]:
    themes = console.available_themes
    for name in sorted(themes, key=lambda name: (name not in _KNOWN, name)):
        now = "now" if name == console.theme else ""
        act = partial(setattr, console, "theme", name)
        shade = "dark night" if themes[name].dark else "light bright day"
        yield Choice(f"Theme {name}", act, now, words=f"colours colors appearance {shade}")
