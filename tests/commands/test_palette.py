"""The palette finds what people type, best first; what it opens takes the keys behind its enter."""

from __future__ import annotations

from pathlib import Path

from archo_tui.screen.choose import ChoiceRows, Fit, fit, matching
from archo_tui.screen.commands.palette import palette_choices
from archo_tui.screen.keyed_app import HELD
from archo_tui.screen.main import PANELS
from archo_tui.screen.terminal import themes
from archo_tui.screen.terminal.stop_marks import dispatch
from tests.support.archo import ARCHO
from tests.support.clock import seconds
from tests.support.console import FAST, Console, click, console, key_event

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
        refused = [bool(one.reason) for one in op.app.screen.query_one(ChoiceRows).items]
        assert refused == sorted(refused)
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
