"""Every command's key, in every place that the table says and in no other."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import pytest
from textual.binding import Binding
from textual.widgets import Button, Input

from archo_tui import screen
from archo_tui.screen import commands
from archo_tui.screen.commands import registry
from archo_tui.screen.commands.base import EVERYWHERE, IN_PANEL, NOT_TYPING, Command, readable_key
from archo_tui.screen.main import PANELS
from archo_tui.screen.widgets.field import INTEGER
from tests.support.archo import ARCHO
from tests.support.front import Front, front
from tests.support.states import STATES
from tests.support.stub import StandingClock

COMMANDS = registry(ARCHO)
PLACES = [f"panel {number}" for number in range(1, 7)] + [
    "shelf field", "begun shelf field", "filter field", "search field", "full screen",
    "edit dialog", "question", "help", "file dialog", "palette",
]  # fmt: skip


# every key, by place: one that is new has to find its room here
KEYS = {
    EVERYWHERE: {
        "ctrl+c": "cancel", "ctrl+x": "stop", "ctrl+p": "palette", "ctrl+z": "suspend",
        "ctrl+q": "quit_everywhere", "f1": "help_everywhere",
    },
    NOT_TYPING: {
        **{str(panel.number): f"panel_{panel.number}" for panel in PANELS},
        "a": "ack", "c": "charge", "g": "go", "h": "history", "k": "skip",
        "n": "continue", "q": "quit", "r": "reset",
        "A": "alarms", "C": "call", "G": "send_goal", "R": "release",
        "left_square_bracket": "shorter", "right_square_bracket": "longer",
        "question_mark": "help",
    },
    "in Parameters": {
        "d": "only_changed", "full_stop": "all_parameters", "u": "undo", "enter": "edit",
        "backspace": "restore",
        "space": "switch", "slash": "filter", "ctrl+s": "save", "ctrl+o": "load",
    },
    "in Nodes": {"s": "start_stop", "plus": "copy", "ctrl+r": "restart", "enter": "details"},
    "in Events": {
        "e": "full_screen", "l": "level", "y": "copy_command", "enter": "whole_event",
        "slash": "search", "ctrl+s": "save_events",
    },
    "in Graph": {"enter": "resource"},
    "KeyedApp": {
        "escape": "leave_field",
    },
    "AlarmList": {
        "a": "acknowledge", "A": "acknowledge_all", "s": "shelve", "enter": "open_diagnostics",
    },
    "ListDialog": {"escape": "close", "q": "close"},
    "DiagnosticList": {"f": "forget", "enter": "close"},
    "TopicDialog": {
        "enter": "fold", "p": "plot", "P": "publish", "space": "freeze",
        "slash": "narrow", "t": "show_type", "y": "copy", "escape": "leave", "q": "close",
    },
    "AnswerRequest": {
        "escape": "close", "q": "close", "up": "scroll(-1)", "down": "scroll(1)",
        "pageup": "scroll(-1)", "pagedown": "scroll(1)",
        "left": "app.focus_previous", "right": "app.focus_next",
    },
    "Choose": {"escape": "close", "pageup": "turn('pageup')", "pagedown": "turn('pagedown')"},
    "Confirm": {
        "escape": "answer(0)", "n": "answer(0)", "y": "yes",
        "left": "app.focus_previous", "right": "app.focus_next",
    },
    "Help": {"escape": "close", "pageup": "scroll(-1)", "pagedown": "scroll(1)"},
    "Form": {"escape": "close"},
    "MessageForm": {"escape": "close", "ctrl+s": "send"},
    "NodeDialog": {
        "escape": "close", "enter": "choose_topic", "q": "close",
        "left": "app.focus_previous", "right": "app.focus_next",
    },
    "RecordingList": {"enter": "play", "y": "copy", "d": "delete", "delete": "delete"},
    "ShowText": {"escape": "close", "enter": "close", "q": "close"},
}  # fmt: skip


def test_every_key_stands_in_the_table_once() -> None:
    found: dict[str, dict[str, str]] = {}
    for command in COMMANDS:
        there = found.setdefault(command.where_text, {})
        assert command.key not in there
        if command.key:
            there[command.key] = command.id
    rooms = {"screen": screen.__path__, "screen.commands": commands.__path__}
    files = [f"{room}.{one.name}" for room, path in rooms.items() for one in iter_modules(path)]
    for name in files:
        module = import_module(f"archo_tui.{name}")
        for thing in vars(module).values():
            if isinstance(thing, type) and thing.__module__ == module.__name__:
                made = [*Binding.make_bindings(vars(thing).get("BINDINGS", ()))]
                bound = found.setdefault(thing.__name__, {}) if made else {}
                for key, action in ((one.key, one.action) for one in made):
                    bound[key] = f"{bound[key]}, {action}" if key in bound else action
    assert found == KEYS


def test_no_key_of_a_panel_is_one_of_every_panel() -> None:
    everywhere = [*KEYS[EVERYWHERE], *KEYS[NOT_TYPING]]
    assert len(set(everywhere)) == len(everywhere)
    for place in ("in Parameters", "in Nodes", "in Events", "in Graph"):
        assert not KEYS[place].keys() & set(everywhere)


async def go_to(it: Front, place: str) -> int:
    """Bring the app to a place by keys; returns the number of the focused panel, 0 for none."""
    keys = {
        "shelf field": ["g"],
        "begun shelf field": ["g"],
        "filter field": ["4", "slash"],
        "search field": ["6", "slash"],
        "full screen": ["6", "e"],
        "edit dialog": ["4", "enter"],
        "question": ["r"],
        "help": ["question_mark"],
        "file dialog": ["4", "ctrl+s"],
        "palette": ["ctrl+p"],
    }.get(place, [place[-1]])
    if place == "panel 3":
        keys = ["3", "tab"]
    await it.press(*keys)
    return it.focused_panel if it.app.screen is it.main else 0


def works(command: Command, place: str, panel: int) -> bool:
    """What the table says."""
    if command.where == EVERYWHERE:
        return True
    if place == "shelf field":  # a number: letters are commands while it is empty
        is_text = len(readable_key(command.key)) > 1 or readable_key(command.key) in INTEGER
        return command.where == NOT_TYPING and not is_text
    main = place.startswith("panel") or place == "full screen"
    return main and (
        command.where == NOT_TYPING or (command.panel is not None and command.panel.number == panel)
    )


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The file dialog saves what is typed into it."""
    monkeypatch.chdir(tmp_path)


async def test_every_key_works_where_the_table_says_and_nowhere_else() -> None:
    async with front(STATES["battery low and moving"], StandingClock()) as it:
        app = it.app
        for place in PLACES:
            while app.screen is not app.main:
                app.pop_screen()
            app.main.remove_class("-full")
            while isinstance(app.focused, Input):
                await it.press("escape")
            panel = await go_to(it, place)
            if isinstance(app.focused, Input) and "shelf" in place:
                app.focused.value = "5" if "begun" in place else ""
            for command in filter(lambda command: command.key, COMMANDS):
                bound = app._bindings.get_bindings_for_key(app.keys[command.id])
                assert any(command.id in binding.action for binding in bound)
                acts = app.check_action("command", (command.id,))
                assert bool(acts) == works(command, place, panel), (place, command)


def test_ids_are_unique_and_every_command_explains_itself() -> None:
    assert len({command.id for command in COMMANDS}) == len(COMMANDS)
    for command in COMMANDS:
        assert len(command.help) > 5
        assert (command.panel is not None) == (command.where == IN_PANEL)


async def test_what_can_be_clicked_on_names_a_command_in_every_state() -> None:
    async with front(clock=StandingClock()) as it:
        known = {f"app.command('{command.id}')" for command in it.app.registry}
        for state in STATES:
            await it.put(STATES[state])
            actions = {
                segment.style.meta["@click"]
                for strip in it.strips
                for segment in strip
                if segment.style is not None and "@click" in segment.style.meta
            }
            actions |= {button.action for button in it.app.query(Button) if button.action}
            assert "app.command('help')" in actions  # of the footer
            assert actions <= known, state
