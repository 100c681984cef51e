"""Every command: its key and where that works, keys of one's own choice, and what finds it."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import pytest
from textual.binding import Binding
from textual.widgets import Button, Input

from archo_tui import screen
from archo_tui.base.errors import ArchoError
from archo_tui.base.paths import config_file
from archo_tui.cli import main
from archo_tui.screen import commands
from archo_tui.screen.choose import ChoiceRows, Fit, fit, matching
from archo_tui.screen.commands import keymap, registry
from archo_tui.screen.commands.base import EVERYWHERE, IN_PANEL, NOT_TYPING, Command, readable_key
from archo_tui.screen.commands.palette import palette_choices
from archo_tui.screen.keyed_app import HELD
from archo_tui.screen.main import PANELS
from archo_tui.screen.terminal import themes
from archo_tui.screen.terminal.stop_marks import dispatch
from archo_tui.screen.widgets.field import INTEGER
from tests.support.archo import ARCHO
from tests.support.clock import seconds
from tests.support.console import FAST, PANEL_KEYS, Console, click, console, key_event
from tests.support.front import Front, front
from tests.support.states import STATES
from tests.support.stub import StandingClock

COMMANDS = registry(ARCHO)


def load(tmp_path: Path, text: str) -> dict[str, str]:
    file = tmp_path / "keymap.yaml"
    file.write_text(text)
    return keymap.load_keymap(file, COMMANDS)[0]


def test_without_a_file_the_registry_decides(tmp_path: Path) -> None:
    keys, _ = keymap.load_keymap(tmp_path / "none.yaml", COMMANDS)
    assert keys == {command.id: command.key for command in COMMANDS}


def test_keys_are_chosen_by_name_or_character(tmp_path: Path) -> None:
    keys = load(tmp_path, "# mine\nstop: F5\nreset: '*'\nfilter: f\nsearch: f\ngo: x\n")
    shown = {name: readable_key(key) for name, key in keys.items()}
    assert keys["stop"] == "f5"
    assert (shown["reset"], shown["filter"], shown["search"], shown["go"]) == ("*", "f", "f", "x")


def test_two_commands_may_swap_their_keys(tmp_path: Path) -> None:
    keys = load(tmp_path, "reset: g\ngo: r\n")
    assert (keys["reset"], keys["go"]) == ("g", "r")


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("\nstop: s\n", 2, "stop must work while typing too: s would be text"),
        ("stop: space\n", 1, "would be text"),
        ("stop: ctrl+i\n", 1, "a terminal sends ctrl+i as tab: choose another"),
        ("stop: ctrl+[\n", 1, "a terminal sends ctrl+[ as escape: choose another"),
        ("stop: backspace\n", 1, "is needed in fields and dialogs"),
        ("reset: hyper+ultra\n", 1, "no key 'hyper+ultra'"),
        (f"reset: {'9' * 5000}\n", 1, f"no key '{'9' * 20}': like"),
        ("reset: g\n", 1, "g is already the key of go"),
        ("filter: u\n", 1, "u is already the key of undo"),
        ("- a\n- b\n", 1, "expected lines like 'stop: ctrl+x'"),
        ("stop: [a]\n", 1, "expected 'command: key'"),
        ("a: b\nb: [\n", 3, "not YAML"),
    ],
)
def test_a_mistake_names_its_line(tmp_path: Path, text: str, line: int, said: str) -> None:
    with pytest.raises(ArchoError) as caught:
        load(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path / 'keymap.yaml'}:{line}: ")
    assert said in str(caught.value)


def test_ids_that_this_robot_lacks_are_left_out_and_said(tmp_path: Path) -> None:
    file = tmp_path / "keymap.yaml"
    file.write_text("stop: f5\nundock: f6\nstpo: f7\n")
    keys, others = keymap.load_keymap(file, COMMANDS)
    assert keys["stop"] == "f5"
    assert others == (
        f"{file}: this robot has no command undock (line 2, nearest: undo), "
        "stpo (line 3, nearest: stop): left out"
    )


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("ctrl+x", "ctrl+x is the key of stop: choose another"),
        ("c", "c is the key of charge: choose another"),
        ("warp", "no key 'warp': like x, ctrl+x, f5, question_mark"),
    ],
)
def test_the_consoles_own_keys_are_not_a_robot_files_to_take(
    tmp_path: Path, key: str, said: str
) -> None:
    charge = ARCHO.commands[0]
    beep = replace(charge, id="beep", where="mine.yaml:7", key=key)
    robot = replace(ARCHO, commands=(charge, beep))
    with pytest.raises(ArchoError) as caught:
        keymap.load_keymap(tmp_path / "none.yaml", registry(robot))
    assert str(caught.value) == f"mine.yaml:7: {said}"


class Replay(Command):
    id, key, help = "replay", "v", "Replay a recording"
    gives_way = True


@pytest.mark.parametrize(
    ("robots", "text", "key"),
    [
        ("", "", "v"),
        ("", "reset: f5\n", "v"),
        ("", "reset: v\n", ""),
        ("v", "", ""),
        ("v", "reset: v\nbeep: f6\n", ""),
        ("v", "beep: f6\n", "v"),
        ("v", "replay: f6\n", "f6"),
    ],
)
def test_a_new_key_yields_to_a_robot_files_and_a_keymaps(
    robots: str,
    text: str,
    key: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    reset = ARCHO.commands[1]
    beep = replace(reset, id="beep", where="mine.yaml:7", key=robots)
    commands = (Replay(), *registry(replace(ARCHO, commands=(reset, beep))))
    file = config_file("keymap.yaml")
    file.parent.mkdir(parents=True)
    file.write_text(text)
    assert keymap.load_keymap(file, commands)[0]["replay"] == key
    monkeypatch.setattr("archo_tui.screen.commands.registry", lambda _: commands)
    assert main(["keys"]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if "replay:" in line)
    if key:
        assert line.split("#")[0].strip() == f"replay: {key}"
    else:
        taker = "reset" if "reset" in text else "beep"
        said = f"# in the palette only, v is the key of {taker}: Replay a recording"
        assert line == f"# replay:                {said}"


def test_a_new_key_that_a_keymap_names_is_kept_or_refused(tmp_path: Path) -> None:
    file = tmp_path / "keymap.yaml"
    file.write_text("reset: v\nreplay: v\n")
    with pytest.raises(ArchoError, match=":1: v is already the key of replay"):
        keymap.load_keymap(file, (*COMMANDS, Replay()))


async def test_a_command_that_yielded_is_in_the_helps_palette_only_part(tmp_path: Path) -> None:
    async with front(keys=load(tmp_path, "") | {"history": ""}, size=(160, 48)) as it:
        lines = (await it.press("f1", *"history")).splitlines()
        titles = [line for line in lines if "In the palette only" in line]
        assert len(titles) == 1
        below = lines[lines.index(titles[0]) + 1]
        assert "Show the history on the full screen" in below


async def test_the_screen_says_and_takes_the_chosen_keys(tmp_path: Path) -> None:
    async with front(keys=load(tmp_path, "go: x\nhelp: f2\n")) as it:
        lines = it.text.splitlines()
        assert f" x Go  ^c Cancel  ^x STOP  r Reset  {PANEL_KEYS} Panels  f2 Help" in lines[-1]
        assert any("Press x, type the shelf" in line for line in lines)
        await it.press("x", "7", "escape", "f2")
        assert it.main.goal.fields[0].value == "7"
        assert it.app.screen is not it.main


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


# what a person types for each entry, and finds it among the first three
TYPED = {
    "Go to shelf": ("go", "shelf", "drive"),
    "Cancel the running goal": ("cancel", "abort", "running goal"),
    "STOP": ("stop", "emergency", "halt"),
    "Cancel every goal": ("cancel every", "all goals", "whoever"),
    "Continue the held queue": ("continue", "resume", "queue"),
    "Skip the next goal": ("skip", "leave out", "drop"),
    "Give up a STOP": ("give up", "forget", "not confirm"),
    "Release the stop": ("release", "unlock", "resume"),
    "Reset the encoder": ("reset", "encoder", "zero"),
    "Charge the battery": ("charge", "battery", "charging"),
    "Send a goal to any action": ("action", "any action", "send goal"),
    "Save the running goal": ("save the queue", "as a list", "running goal and"),
    "Publish a message": ("publish", "pub", "message"),
    "Call any service": ("service", "call", "any service"),
    "Describe this robot": ("describe", "new robot", "discover"),
    "Acknowledge the alarm": ("ack", "acknowledge", "seen"),
    "List the diagnostics": ("diagnostics", "parts", "hardware"),
    "List the alarms": ("alarms", "shelve", "warnings"),
    "Edit the selected parameter": ("edit", "edit parameter", "selected parameter"),
    "Restore the selected parameter": ("restore", "default", "at the start"),
    "Toggle the selected boolean": ("switch", "toggle", "boolean"),
    "Show only changed parameters": ("differ", "modified", "diff"),
    "Filter the parameters": ("filter", "whose", "find parameters"),
    "Show or hide the other parameters": ("hidden parameters", "every ros", "ros own"),
    "Show the selected topic": ("topic", "interface", "type service"),
    "Show the transforms": ("tf", "frames", "transforms"),
    "Undo your last change": ("undo", "revert", "last change"),
    "Save all parameters": ("save parameters", "export yaml", "dump"),
    "Load a ROS parameter file": ("load", "import", "open yaml"),
    "Start or stop the selected node": ("start node", "kill", "restart"),
    "Start another copy": ("copy node", "another", "duplicate"),
    "Restart for what was saved": ("reload", "restart saved", "saved"),
    "Show the selected node": ("details", "traceback", "crash"),
    "Choose the lowest level": ("level", "debug", "severity"),
    "Search the events": ("search", "find events", "grep"),
    "Copy the ros2 command": ("ros2", "clipboard", "copy command"),
    "Show the events on the full": ("full screen", "log", "zoom"),
    "Show the selected event": ("selected event", "in full", "open event"),
    "Save the events": ("save events", "export events", "export log"),
    "Show the history": ("history", "plot", "chart"),
    "Show a shorter": ("shorter", "zoom in", "short history"),
    "Show a longer": ("longer", "zoom out", "hour"),
    "Show the keys of the panel": ("panel shortcuts", "keys of the panel", "here"),
    "Show all keys": ("manual", "all keys", "help"),
    "Keep the last minute": ("record", "bag", "keep last"),
    "List the recordings": ("replay", "black box", "recordings"),
    "Turn the bell": ("mute", "bell", "sound"),
    "Suspend to the shell": ("suspend", "shell", "background"),
    "Quit": ("quit", "exit", "close"),
    "Set motor_controller max_speed": ("speed", "max_speed", "sp"),
    "Set motor_controller wheel_radius": ("wheel", "radius", "set wheel"),
    "Set motor_controller ticks_per_revolution": ("ticks", "revolution", "per rev"),
    "Set battery_monitor low_battery_threshold": ("threshold", "low battery", "set low"),
    "Node battery_monitor": ("node battery", "monitor", "battery info"),
    "Node dashboard": ("dashboard", "dash", "node dash"),
    "Node motor_controller": ("node motor", "motor info", "controller details"),
    "Topic /battery_level": ("topic battery", "level topic", "echo battery"),
    "Topic /motor_status": ("topic motor", "motor status", "plot motor"),
    "Choose a theme": ("theme", "high contrast", "light colors"),
    "Save a picture of the screen": ("screenshot", "picture", "svg"),
    **{
        f"Go to panel {panel.number}, {panel.title_for(ARCHO)}": (
            f"panel {panel.number}",
            f"{panel.title_for(ARCHO)} panel",
            f"go {panel.title_for(ARCHO)}",
        )
        for panel in PANELS
    },
}


def first(op: Console, count: int = 3) -> list[str]:
    """The titles of the first rows."""
    return [one.title for one in op.app.screen.query_one(ChoiceRows).items[:count]]


async def test_each_entry_is_found_by_three_words_that_people_type() -> None:
    async with console(*FAST) as op:
        choices = palette_choices(op.app)
        titles = [one.title for one in choices]
        named = [t for t in titles if not t.startswith(("Set", "Node", "Topic"))]
        assert [t for t in named if not t.startswith(tuple(TYPED))] == []

        def found(typed: str, count: int) -> list[str]:
            return [one.title for one in matching(typed, choices)[:count]]

        for title, three in TYPED.items():
            assert len(set(three)) == 3
            for typed in three:
                assert any(t.startswith(title) for t in found(typed, 3)), (title, typed)
        for typed, meant in (
            ("exit", "Quit"),
            ("export", "Save all parameters to a ROS parameter file"),
            ("record", "Keep the last minute"),
            ("dark", "Choose a theme"),
        ):
            assert meant in found(typed, 8), typed


def test_whole_words_come_before_beginnings_and_those_before_what_is_inside() -> None:
    fits = [fit("stop", name) for name in ("the stop", "stopped", "unstoppable", "s to p", "pots")]
    assert fits == [Fit.WORD, Fit.BEGINNING, Fit.INSIDE, Fit.NONE, Fit.NONE]
    assert fit("exit", "Quit", "exit leave") == Fit.WORD
    assert fit("textual-d", "Theme textual-dark") == Fit.BEGINNING


async def test_the_palette_says_what_can_be_done_now_with_refusals_below() -> None:
    async with console(*FAST) as op:
        await op.press("ctrl+p")
        assert [one.split()[0] for one in first(op)] == ["Go", "Cancel", "STOP"]
        await op.type("max sp")
        assert first(op)[0] == "Set motor_controller max_speed"
        assert "Go" not in [one.split()[0] for one in first(op)]

        await op.press("escape")
        await op.press("ctrl+p")
        await op.type("stop")
        assert len(first(op, 9)) < 9
        assert first(op, 1) == ["STOP"]
        assert "Release the stop (asks first)" in first(op, 9)

        await op.press("escape")
        refused = "the robot is not stopped"
        robot = op.app.station.robot
        await op.press("ctrl+p")
        await op.type("release")
        await op.until(refused)
        await robot.emergency_stop()
        await op.until(lambda: refused not in op.text)
        await robot.release_emergency_stop()
        await op.until(refused)

        await op.press("escape")
        await op.press("ctrl+p")
        await op.type("set motor_controller m")
        rows = op.app.screen.query_one(ChoiceRows)
        await op.press("down")
        before, here = [one.title for one in rows.items], rows.cursor
        await op.app.station.robot.set_parameters("/motor_controller", {"max_speed": 1.25})
        await op.until("1.25")
        assert ([one.title for one in rows.items], rows.cursor) == (before, here)

        await op.press("escape")
        op.send("ctrl+p", "#", "enter")
        await op.until("no command matches")
        op.send("backspace", *"theme", "enter")
        await op.until("Theme nord")
        await op.type("nord")
        assert first(op) == ["Theme nord"]
        await op.press("enter")
        assert op.app.theme == "nord"
        await op.until(lambda: themes.remembered_theme() == "nord")
        assert op.app.screen is op.app.main

        await op.press("escape", "escape")
        await op.press("ctrl+p", "down", "down", "up")
        rows = op.app.screen.query_one(ChoiceRows)
        assert rows.cursor == 1
        await op.press("pagedown")
        assert rows.cursor > 10
        await op.press("pageup", "pageup")
        assert rows.cursor == 0

        await op.press("escape")
        await op.press("ctrl+p", *"theme", "enter", *"high")
        row = op.app.screen.query_one(ChoiceRows).region
        click(op.app, row.x + 3, row.y)
        await op.until(lambda: op.app.theme == "high-contrast")
        assert op.app.screen is op.app.main

        await op.press("escape", "escape")
        await op.press("ctrl+p")
        await op.type("release")
        line = op.line("Release the stop")
        assert line.rstrip(" ┃").endswith("the robot is not stopped"), line
        await op.press(*["backspace"] * 7)
        unable = [bool(one.reason) for one in op.app.screen.query_one(ChoiceRows).items]
        assert unable == sorted(unable)
        await op.press("escape", "ctrl+x")
        await op.until("R releases")
        await op.press("ctrl+p")
        assert first(op, 1) == ["Release the stop (asks first)"]


async def test_a_picture_shows_the_screen_without_the_palette(here: Path) -> None:
    async with console(*FAST) as op:
        await op.press("ctrl+p", *"picture", "enter")
        await op.until("SVG file")
        await op.press("enter")
        await op.until("Saved to archo.svg.")
        picture = (here / "archo.svg").read_text()
        assert picture.startswith("<svg")
        assert "Battery" in picture
        assert "type a part of its name" not in picture


async def test_a_watching_console_says_why_nothing_acts() -> None:
    async with console(*FAST, watch=True) as op:
        await op.press("ctrl+p")
        for typed in ("stop", "speed", "release"):
            await op.type(typed)
            assert "watching" in op.app.screen.query_one(ChoiceRows).items[0].reason
            await op.press(*["backspace"] * len(typed))


async def test_eight_keys_at_once_change_the_speed_and_a_stop_behind_them_voids_it() -> None:
    async with console(*FAST) as op:
        op.send("ctrl+p", "s", "p", "enter", "0", ".", "5", "enter")
        await op.until(lambda: op.app.view.snapshot.parameter("max_speed").value == 0.5)  # type: ignore[union-attr]
        await op.until(lambda: op.app.screen is op.app.main)
        await op.press("g", "ctrl+p", "s", "p", "enter", "0", ".", "4", "enter")
        await op.until(lambda: op.app.view.snapshot.parameter("max_speed").value == 0.4)  # type: ignore[union-attr]
        assert op.app.screen is op.app.main

        await op.press("escape")
        keys = ("ctrl+p", "s", "p", "enter", "0", ".", "5", "enter", "ctrl+x")
        dispatch(map(key_event, keys), op.app, op.app.stop_typed, op.app.post_message)
        await op.until(lambda: op.app.view.snapshot.motion.stopped)
        await op.settle()
        assert op.app.screen is op.app.main
        assert op.app.view.snapshot.parameter("max_speed").value == 0.4  # type: ignore[union-attr]
        await op.at(seconds() + HELD)
        await op.press("R", "y")
        await op.until("● IDLE")

        await op.press("4", "slash")
        await op.type("max_speed")
        await op.press("enter", "down")
        op.send("ctrl+p", "g", "o", "ctrl+x", "enter", "1", "enter")
        await op.until("STOP closed the dialog: press the key again.")
        assert op.app.screen is op.app.main
        assert op.app.view.snapshot.parameter("max_speed").value == 0.4  # type: ignore[union-attr]
        await op.at(seconds() + HELD)
        await op.press("R")
        await op.until("Release the stop?")
        await op.press("y")
        await op.until("● IDLE")


async def test_in_a_small_terminal_a_reason_stands_below_and_help_has_pages() -> None:
    async with console(*FAST, size=(80, 24)) as op:
        await op.press("ctrl+p")
        await op.type("give up a STOP")
        title = "Give up a STOP that the robot does not confirm, and send it no more"
        assert op.line(title)
        (choice,) = op.app.screen.query_one(ChoiceRows).items
        assert f"1 of {len(palette_choices(op.app))}   not now: {choice.reason}" in op.text

        await op.press("escape")
        await op.press("f1")
        top = op.text
        await op.press("pagedown")
        assert op.text != top
        await op.press("pageup")
        assert op.text == top
