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


def bound_in_dialogs() -> list[tuple[str, str]]:
    """Return each key that a class of the screen binds by itself, behind the name of the class."""
    rooms = {"screen": screen.__path__, "screen.commands": commands.__path__}
    files = [f"{room}.{one.name}" for room, path in rooms.items() for one in iter_modules(path)]
    modules = [import_module(f"archo_tui.{name}") for name in files]
    own = [(kind, module) for module in modules for kind in vars(module).values()]
    return [
        (kind.__name__, binding.key)
        for kind, module in own
        if isinstance(kind, type) and kind.__module__ == module.__name__
        for binding in Binding.make_bindings(vars(kind).get("BINDINGS", ()))
    ]


def test_no_key_has_two_meanings_in_one_place() -> None:
    found = [(command.where_text, command.key) for command in COMMANDS if command.key]
    everywhere = [key for where, key in found if where in (EVERYWHERE, NOT_TYPING)]
    panels = {key for where, key in found if where not in (EVERYWHERE, NOT_TYPING)}
    assert len(set(everywhere)) == len(everywhere) > 20
    assert not panels & {*everywhere}
    found += bound_in_dialogs()
    assert len(set(found)) == len(found) > 60
    always = {key for where, key in found if where == EVERYWHERE}
    assert not always & {key for _, key in bound_in_dialogs()}  # STOP acts in each of them.


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
