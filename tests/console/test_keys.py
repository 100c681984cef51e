"""Focus, keys, help, fields: the keyboard leads everywhere and back."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node
from textual import events
from textual._compositor import Compositor
from textual.events import MouseDown, MouseUp
from textual.geometry import Size
from textual.screen import Screen
from textual.widgets import Input

from archo_tui.screen.commands.base import PanelKey
from archo_tui.screen.commands.parameters import EditParameter
from archo_tui.screen.terminal.stop_marks import dispatch
from archo_tui.screen.widgets.bars import FooterKey, footer
from archo_tui.screen.widgets.field import Field
from tests.support.clock import seconds
from tests.support.console import FAST, LONG, PANEL_KEYS, Console, console, key_event
from tests.support.night import corners
from tests.support.stand_in import Made, StandIn

PLACES = ("Everywhere", "Not while typing", "In Events")


async def test_numbers_and_tab_walk_through_the_panels_and_escape_leads_back() -> None:
    async with console(*FAST) as op:
        for number in "12456":
            await op.press(number)
            assert op.focused_panel == int(number)
        await op.press("1")
        seen = []
        for _ in range(10):
            seen.append(op.focused_panel)
            await op.press("tab")
        assert seen == [1, 2, 2, 2, 3, 3, 3, 4, 5, 6]  # field, Go, Cancel

        await op.press("6", "g", "1", "escape")
        assert op.app.focused is not None
        assert op.app.focused.id == "event-list"
        assert op.app.query_one("#goal-0", Input).value == "1"

        await op.press("4", "slash", "s")
        op.app.main.focus_panel(3)  # as a click on the footer's Go does
        await op.settle()
        assert isinstance(op.app.focused, Input)
        await op.press("escape")
        assert not isinstance(op.app.focused, Input)
        assert op.focused_panel == 4


async def test_letters_are_text_while_typing_and_commands_in_an_empty_field_for_numbers() -> None:
    async with console(*FAST) as op:
        await op.press("4", "slash")
        await op.type("rqac1?")
        assert op.app.main.parameters.search.value == "rqac1?"
        assert op.app.screen is op.app.main

        await op.press("escape")
        await op.press("g", "c")
        await op.until("✓  charge")
        assert op.app.query_one("#goal-0", Input).value == ""
        await op.press("question_mark")
        await op.until("Keys")

        await op.press("escape")
        await op.press("R")
        await op.until("the robot is not stopped")
        assert op.app.screen is op.app.main  # and nothing is asked


async def test_keys_of_dialogs_are_for_them_alone() -> None:
    async with console(*FAST) as op:
        await op.press("4", "full_stop", "ctrl+end", "enter")
        await op.until("ticks_per_revolution is read-only")
        await op.press("r", "c", "q")
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)
        await op.press("a")
        await op.until("no alarm to acknowledge")  # whatever r and c did is done by now
        assert "15 420 ticks" in op.text
        assert not [event for event in op.app.view.snapshot.events if event.level == "YOU"]

        await op.press("escape", "escape")
        await op.press("4")
        assert "Press g, type the shelf, press enter." in op.text
        await op.press("g")
        assert "No goal yet. Type the shelf, press enter." in op.text

        await op.press("escape", "escape")
        await op.press("4", "question_mark")
        await op.until("Here, in Parameters")
        assert op.text.count("Undo your last change of a parameter") == 1
        assert op.text.index("Undo") < op.text.index("Everywhere") < op.text.index("Suspend")
        assert "In Parameters" not in op.text
        await op.press(*"reset")
        await op.until("Reset the encoder")
        assert "Undo" not in op.text
        await op.press("escape")
        assert op.app.screen is op.app.main

        await op.press("4", "slash", "f1")
        await op.until("Keys")
        assert "STOP" in op.text.splitlines()[-1]  # its key stays where it is
        await op.press("f1")
        await op.until(lambda: op.app.screen is op.app.main)

        await op.press("escape", "escape")
        for opening, ending in (
            (["question_mark"], "escape"),
            (["A"], "q"),
            (["4", "enter"], "escape"),
            (["4", "ctrl+s"], "escape"),
            (["5", "enter"], "q"),
        ):
            await op.press(*opening)
            await op.until(lambda: op.app.screen is not op.app.main)
            op.send(ending, ending)
            await op.until(lambda: op.app.screen is op.app.main)
            await op.pilot.pause()
            while op.app.screen is not op.app.main:  # the second may have opened another
                await op.press("escape")
        await op.press("ctrl+x")
        await op.until("✗ STOPPED")
        await op.press("R")
        await op.until("Release the stop?")
        op.send("enter", "enter", "enter")
        await op.until(lambda: op.app.screen is op.app.main)
        assert "✗ STOPPED" in op.text

        await op.press("escape", "escape")
        await op.press("ctrl+x")
        await op.until("✗ STOPPED")
        op.send(*["ctrl+x"] * 3)
        await op.settle()
        await op.press("R", "y")
        await op.until("● IDLE")
        assert op.app.stops.are_answered
        assert op.app.station.restart_blocker == ""


async def test_a_dialog_that_is_done_goes_behind_help_and_saves_before_the_end(here: Path) -> None:
    file = here / "archo_params.yaml"
    async with console(*FAST) as op:
        await op.press("4", "ctrl+s")
        await op.until("ROS parameter file")
        op.send("enter", "f1")
        await op.until(file.exists)
        await op.settle()
        assert "Keys" in op.text
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)

        file.unlink()
        await op.press("4", "ctrl+s")
        await op.until("ROS parameter file")
        op.send("enter", "ctrl+q")
        await op.until(lambda: not op.app.is_running)
    assert file.exists()


async def test_help_lists_every_command_with_its_key() -> None:
    async with console(*FAST, size=(120, 120)) as op:
        await op.press("f1")
        await op.until("Keys")
        for command in op.app.registry:
            if not isinstance(command, PanelKey):
                assert command.help.split(" (")[0][:30] in op.text
        assert f"{PANEL_KEYS}  Go to a panel" in op.text
        at = {place: (op.line(place).index(place), op.text.index(place)) for place in PLACES}
        assert at["Everywhere"][0] == at["Not while typing"][0] < at["In Events"][0]
        assert at["Everywhere"][1] < at["Not while typing"][1]
        assert op.line("In the palette only")
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)


async def test_a_click_does_what_the_key_does() -> None:
    async with console(*FAST, size=(120, 36)) as op:
        lines = op.text.splitlines()
        footer = lines[-1]
        await op.pilot.click(offset=(footer.index("r Reset") + 1, len(lines) - 1))
        await op.until("reset encoder: Encoder reset to zero")
        row = next(n for n, line in enumerate(lines) if "max_speed" in line)
        await op.pilot.click(offset=(60, row))
        await op.pilot.click(offset=(60, row))
        await op.until(" motor_controller max_speed ")
        await op.press("escape")
        border = next(n for n, line in enumerate(lines) if "c charge" in line)
        await op.pilot.click(offset=(lines[border].index("c charge") + 2, border))
        await op.until("✓  charge")


async def test_what_is_typed_ahead_of_the_robot_goes_into_the_field() -> None:
    async with console(node_makers=[partial(Node, "nobody")], wait=False) as op:
        await op.until("● nobody")
        assert "move_to_shelf is not offered by any node" in op.text
        await op.press("g", "1", "2", "enter")
        await op.until("move_to_shelf is not offered by any node")
        await op.press("up")
        assert op.app.query_one("#goal-0", Input).value == "12"
        assert op.focused_panel == 3


def _said(op: Console) -> list[str]:
    return [event.text for event in op.app.view.snapshot.events if event.level == "YOU"]


@pytest.mark.parametrize("key", corners(["r", "ctrl+x"], ["c"]))
async def test_a_held_key_sends_a_command_once_and_a_new_press_sends_it_again(key: str) -> None:
    async with console(*FAST) as op:
        begin = seconds()
        await op.press(key)
        for after in (0.5, *(0.53 + 0.03 * n for n in range(20))):  # as a keyboard repeats
            await op.at(begin + after)
            op.send(key)
        await op.settle()
        await op.until(lambda: _said(op))
        assert len(_said(op)) == 1
        await op.press("1", key)
        await op.until(lambda: len(_said(op)) == 2)


async def test_a_stop_that_a_watching_console_refuses_leaves_nothing_to_be_answered() -> None:
    async with console(*FAST, watch=True) as op:
        await op.press("ctrl+x")
        button = op.app.main.query_one("#stop").region
        app, (x, y) = op.app, button.offset
        where: Any = (None, x, y, 0, 0, 1, False, False, False, x, y)
        read = [MouseDown(*where), MouseUp(*where)]  # As the terminal's driver marks them.
        dispatch(read, app, app.stop_typed, app.post_message)
        await op.until(lambda: op.app.stops.count == 2)
        assert op.app.stops.are_answered


async def test_enter_that_was_held_while_the_screen_stood_still_sets_nothing() -> None:
    async with console(*FAST) as op:
        await op.press("4", "enter")
        held = seconds() + 0.3
        await op.at(held + 2.0)  # The screen comes to it only now.
        app = op.app
        dispatch([key_event("enter")], app, app.stop_typed, app.post_message, held)
        await op.until("press it again")
        assert not _said(op)


async def test_an_unanswered_stop_is_sent_again_every_half_second_while_the_key_is_held() -> None:
    deaf = Made(StandIn, "deaf", "nothing")
    async with console(node_makers=[deaf], wait=False) as op:
        await op.until(lambda: "emergency_stop" in op.app.view.snapshot.offered)
        begin = seconds()
        for number in range(40):
            await op.at(begin + 0.03 * number)
            op.send("ctrl+x")
        await op.settle()
        assert 1 < len(deaf.node.stops) <= 3
        await op.until("use the hardware stop")


async def test_help_begins_with_the_state_and_the_field_and_letters_act_behind_enter() -> None:
    async with console(*LONG) as op:
        await op.press("g", "question_mark")
        field = [op.text.index(word) for word in ("Here, in Go to shelf", "Recent goals", "Leave")]
        assert field == sorted(field)
        assert field[-1] < op.text.index("Everywhere")
        await op.press("escape")
        op.send(*"12 7", "enter", "c")
        await op.until("MOVING to 12")
        await op.until("✓  charge")
        assert op.app.query_one("#goal-0", Input).value == ""
        await op.press("ctrl+x")
        await op.until("held: 7")
        await op.press("question_mark")
        now = op.text.index("Now")
        assert op.text.index("Release the stop") < op.text.index("Continue the held queue")
        assert now < op.text.index("Release the stop") < op.text.index("Here, in")


async def test_what_comes_in_one_write_acts_in_its_order() -> None:
    async with console(*FAST) as op:
        op.send("g", "1", "2", "backspace", "3", "enter")
        await op.until("Arrived at shelf 13")
        assert [goal.target for goal in op.app.view.snapshot.history] == ["13"]

        await op.press("escape")
        names = op.parameters
        row = names.index("low_battery_threshold")
        op.send("4", "home", *["down"] * row, "enter", "2", "5", "backspace", "1", "enter")
        await op.until("low_battery_threshold is 21.0, was")

        await op.press("escape", "escape")
        await op.press("g", "1")
        op.app.post_message(events.Paste("2x\x183"))
        await op.until("cannot paste this here: it contains 'x'")
        assert op.app.query_one("#goal-0", Field).value == "1"
        op.app.post_message(events.Paste("23"))
        await op.until(lambda: op.app.query_one("#goal-0", Field).value == "123")

        await op.press("escape")
        await op.press("4", "enter")
        await op.until(lambda: isinstance(op.app.screen, EditParameter))
        await op.settle()
        field = op.app.screen.query_one(Field)
        before = field.value
        op.app.post_message(events.Paste("1\n2"))
        await op.until("cannot paste this here: it has several lines")
        assert field.value == before
        op.app.post_message(events.Paste("7\n"))
        await op.until(lambda: "7" in field.value)

        await op.press("escape", "escape")
        await op.press("g")
        op.app.post_message(events.Paste(" 12\t\r\n"))
        op.send("enter", "h")  # enter clears the field, and so h is a command again
        await op.until(lambda: op.app.main.is_full)
        await op.until(lambda: op.app.view.snapshot.history[0].target == "12")


async def test_only_the_left_button_acts() -> None:
    async with console(*FAST) as op:
        x, y = op.app.query_one("#stop").region.offset
        for button in (3, 2, 1):
            assert not [e for e in op.app.view.snapshot.events if e.level == "YOU"]
            for kind in (events.MouseDown, events.MouseUp):
                mouse = kind(None, x + 2, y, 0, 0, button, False, False, False)
                op.app.post_message(mouse)
            await op.settle()
        await op.until("✗ STOPPED")


async def test_a_fields_keys_are_in_the_footer_and_typing_lays_nothing_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    laid_out: list[Screen[object]] = []
    lay_out = Compositor.reflow

    def counted(compositor: Compositor, screen: Screen[object], size: Size) -> object:
        laid_out.append(screen)
        return lay_out(compositor, screen, size)

    async with console() as op:
        await op.until(f"g Go  ^c Cancel  ^x STOP  r Reset  {PANEL_KEYS} Panels")
        await op.press("g")
        assert op.text.splitlines()[-1].startswith(
            " enter Go  ↑ ↓ Recent goals  esc Leave  ^c Cancel  ^x STOP  "
        )
        await op.press("1")
        with monkeypatch.context() as counting:
            counting.setattr(Compositor, "reflow", counted)
            await op.press("2", "backspace")
            assert laid_out == []
            await op.press("escape", "h")
            assert laid_out != []
        await op.press("escape", "escape", "4", "slash")
        await op.until("enter Keep filter  esc Clear  ^c Cancel  ^x STOP")
        await op.press("escape")
        await op.until(f"{PANEL_KEYS} Panels")

        await op.press("4", "slash", *"abcdefghij" * 20, "1", "2", "3")
        field = op.app.focused
        assert isinstance(field, Field)
        assert field.region.width < 203
        assert "hij123" in op.text
        assert "abcdefghij" * 20 not in op.text
        await op.press("home")
        assert "abcdefghij" in op.text
        assert "123" not in op.text.splitlines()[field.region.y]
        await op.press("end", "ctrl+u")
        assert field.max_scroll_x == 0


IN_FOOTER = [
    FooterKey("go", "g", "Go", False, False),
    FooterKey("stop", "^x", "STOP", False, True),
]


@pytest.mark.parametrize(
    ("width", "shown"),
    [
        (60, " enter Go  ↑ ↓ Recent goals  esc Leave  ^x STOP "),
        (47, " enter Go  esc Leave  ^x STOP "),
        (20, " enter Go  ^x STOP "),
        (10, " ^x STOP "),
    ],
)
def test_a_fields_keys_leave_room_for_the_one_that_stops(width: int, shown: str) -> None:
    keys = ("enter", "Go"), ("↑ ↓", "Recent goals"), ("esc", "Leave")
    line = footer(IN_FOOTER[1:], width, "^p", keys).plain
    assert line.partition("  ^p")[0].rstrip() == shown.rstrip()
