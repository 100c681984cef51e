"""An operator sends the robot to shelves."""

from __future__ import annotations

import json
import re

from textual import events
from textual.widgets import Input

from archo_tui.base.paths import journal_file
from tests.support import clock
from tests.support.clock import seconds
from tests.support.console import BRISK, FAST, LONG, console


async def test_a_goal_is_typed_driven_and_arrives() -> None:
    async with console(*FAST) as op:
        await op.press("g")
        await op.type("12")
        await op.press("enter")
        await op.until("✓ ARRIVED      Arrived at shelf 12, 18.0 m in ")
        assert "100 %" in op.text
        await op.until("last goals: ✓ 12 arrived")
        assert "go to shelf 12: accepted" in op.text
        sent = next(event for event in op.app.view.snapshot.events if "accepted" in event.text)
        assert sent.command.startswith("ros2 action send_goal /move_to_shelf")
    kept = [json.loads(line) for line in journal_file().read_text().splitlines()]
    assert [e["text"] for e in kept if e["kind"] == "goal"] == ["Arrived at shelf 12"]


async def test_the_way_left_is_shown_and_ctrl_c_or_the_button_cancels() -> None:
    async with console(*LONG) as op:
        await op.press("g", "1", "2", "enter")
        await op.until(lambda: re.search(r"MOVING to 12   9\d\d\.\d m left of 1000\.0 m", op.text))
        await op.until(lambda: re.search(r"so far, about \d+\.?\d* \w+ left", op.text))
        assert "MOVING to 12" in op.text.splitlines()[0]
        await op.until("▶ MOVING")
        await op.type("7")
        await op.press("ctrl+c")
        await op.until("✗ CANCELLED    Cancelled mid-route, ")
        assert op.app.query_one("#goal-0", Input).value == "7"
        await op.until("cancel: accepted")
        events = op.app.view.snapshot.events
        (command,) = (e.command for e in events if e.text == "cancel: accepted")
        assert command.startswith("ros2 service call /move_to_shelf/_action/cancel_goal")
        assert op.app.view.snapshot.goal is not None
        remaining = op.app.view.snapshot.goal.remaining
        assert remaining is not None
        assert 0 < remaining < 1000
        await op.until("● IDLE")

        await op.press("ctrl+u", "escape")
        await op.press("g", "5", "enter")
        await op.until("MOVING to 5")
        await op.pilot.click("#cancel")
        await op.until("✗ CANCELLED")


async def test_what_is_no_shelf_is_said_and_sends_nothing() -> None:
    async with console(*FAST) as op:
        await op.press("g")
        for typed, said in (
            ("abc", "Shelf: not a whole number: abc"),
            ("0", "Shelf: at least 1, not 0"),
            ("41", "Shelf: at most 40, not 41"),
            ("٣", "Shelf: not a whole number: ٣"),
        ):
            op.app.query_one("#goal-0", Input).value = typed
            await op.press("enter")
            await op.until(said)
        assert "No goal yet." in op.text
        assert op.app.view.snapshot.goal is None

        await op.press("ctrl+u")
        await op.press("g")
        op.app.query_one("#goal-0", Input).insert_text_at_cursor("9" * 10_000)
        await op.press("enter")
        await op.until("Shelf: at most 40, not 999")
        assert op.app.view.snapshot.goal is None

        await op.press("ctrl+u")
        await op.press("g")
        op.app.post_message(events.Paste("12"))
        op.send("r", "enter")
        await op.until("Shelf: not a whole number: 12r")

        await op.press("ctrl+u")
        await op.press("g", "1", "r", "backspace", "backspace", "c")
        await op.until("✓  charge")
        assert op.app.query_one("#goal-0", Input).value == ""

        await op.press("ctrl+u")
        await op.press("ctrl+c")
        await op.until("Press q (or")
        assert op.app.is_running

        await op.press("ctrl+u")
        await op.press("g", "5")
        await op.pilot.click("#go")
        await op.until("Arrived at shelf 5")


async def test_a_red_hint_leaves_with_the_next_key() -> None:
    async with console(*LONG) as op:
        await op.press("g", "ctrl+x")
        await op.until("✗ STOPPED")
        await op.press("7", "enter")
        await op.until("emergency stop: release it first")
        await op.press("escape")
        await op.until(lambda: "release it first" not in op.line("Shelf"))
        await op.press("R", "y")
        await op.until("● IDLE")
        await op.press("g", *"45", "enter")
        await op.until("Shelf: at most 40")
        await op.press("left")
        await op.until(lambda: "at most 40" not in op.text)


async def test_letters_in_a_number_are_shown_and_refused_not_dropped_or_done() -> None:
    async with console(*FAST) as op:
        for typed in ("1ox5", "o15", "1r", "1rcq", "12s", "0x10", "15a", "1_2"):
            await op.press("g", "ctrl+u")
            op.send(*typed, "enter")
            await op.until(f"Shelf: not a whole number: {typed}")
            assert op.app.query_one("#goal-0", Input).value == typed
            await op.press("backspace", "r")  # what was refused can be mended, and is still text
            assert op.app.query_one("#goal-0", Input).value == f"{typed[:-1]}r"
            assert op.app.screen is op.app.main
            assert op.app.view.snapshot.goal is None
            assert not [event for event in op.app.view.snapshot.events if event.level == "YOU"]
            await op.at(clock.seconds() + 1.0)


async def test_a_held_ctrl_c_cancels_once_and_then_says_nothing() -> None:
    async with console(*LONG) as op:
        await op.press("g", "1", "2", "enter")
        await op.until("m left of")
        begin = seconds()
        for number in range(60):  # as a keyboard repeats
            await op.at(begin + 0.03 * number)
            op.send("ctrl+c")
        await op.until("✗ CANCELLED")
        assert "No goal is running" not in op.text
        said = [event.text for event in op.app.view.snapshot.events if event.level == "YOU"]
        assert said.count("cancel: accepted") == len(said) - 1 == 1  # and that it was sent


async def test_the_form_of_a_goal_shows_its_range_and_offers_no_value_beyond() -> None:
    async with console(*BRISK) as op:
        await op.press("G", *"move", "enter")
        await op.until("esc cancel")
        assert "int32, 1 .. 40" in op.line("┃ Shelf")
        assert "0 int32" not in op.words
        await op.press("enter")
        await op.until("Shelf: type a value")
        await op.press(*"12", "enter")
        await op.until("MOVING to 12")
