"""A number typed in the palette is a goal, sent as the form sends it, and once."""

from __future__ import annotations

import pytest

from archo_tui.screens.choose import ChoiceRows, matched_spans
from tests.support.console import FAST, LONG, Console, console


def rows(op: Console) -> list[tuple[str, str]]:
    """The titles of the rows, and why they cannot be done."""
    found = op.app.screen.query_one(ChoiceRows).items
    return [(choice.title, choice.reason) for choice in found]


def accepted(op: Console) -> list[str]:
    """What was accepted, by the events."""
    events = op.app.view.snapshot.events
    return [event.text for event in events if "accepted" in event.text]


async def test_one_number_or_several_are_goals_and_a_wrong_one_says_why() -> None:
    async with console(*FAST) as op:
        await op.press("ctrl+p", "9", "9")
        assert rows(op)[0] == ("Go to shelf 99", "Shelf: at most 40, not 99")
        await op.press("enter")
        await op.until("not sent: Shelf: at most 40, not 99")
        assert op.app.view.snapshot.goal is None

        await op.press("escape")
        await op.press("ctrl+p", *"reset")
        list_rows = op.app.screen.query_one(ChoiceRows)
        number = next(n for n, row in enumerate(rows(op)) if row[0].startswith("Reset the encoder"))
        lit = [s.text for s in list_rows.render_line(number) if s.style and s.style.underline]
        assert lit == ["Reset"]
        await op.press("backspace")
        lit = [s.text for s in list_rows.render_line(0) if s.style and s.style.underline]
        assert "".join(lit).lower() == "rese"

        await op.press("escape")
        await op.press("ctrl+p", "1", "2")
        assert rows(op)[0] == ("Go to shelf 12", "")
        await op.press("enter")
        await op.until("Arrived at shelf 12")
        assert op.app.main.goal.typed[-1] == ["12"]  # For the arrow keys.
        assert op.app.main.goal.fields[0].value == ""

        await op.press("escape")
        await op.press("ctrl+p", *"12", "space", "7")
        assert rows(op)[0] == ("Go to shelf 12, 7", "")
        await op.press("enter")
        await op.until("Arrived at shelf 12")
        await op.until("Arrived at shelf 7")

        await op.press("escape")
        await op.press("ctrl+x")
        await op.until("R releases")
        await op.press("ctrl+p", "7", "enter")
        await op.until(lambda: "release it first" in op.line("Shelf "))
        assert op.app.view.snapshot.running_goal is None


@pytest.mark.parametrize("enters", [2, 12])
async def test_a_burst_and_a_held_enter_send_it_once(enters: int) -> None:
    async with console(*LONG) as op:
        op.send("ctrl+p", "1", "2", *["enter"] * enters)
        await op.until("MOVING to 12")
        await op.settle()
        assert accepted(op) == ["go to shelf 12: accepted"]
        assert op.app.view.queue == ()
        assert op.app.screen is op.app.main


async def test_a_stop_before_its_enter_sends_nothing() -> None:
    async with console(*LONG) as op:
        op.send("ctrl+p", "1", "2", "ctrl+x", "enter")
        await op.until("R releases")
        await op.settle()
        assert op.app.view.snapshot.goal is None


async def test_a_console_that_watches_sends_none() -> None:
    async with console(*FAST, watch=True) as op:
        await op.press("ctrl+p", "7")
        assert rows(op)[0][0] == "Go to shelf 7"
        assert rows(op)[0][1] != ""
        await op.press("enter")
        await op.settle()
        assert op.app.view.snapshot.goal is None


def test_what_matches_is_lit_where_a_word_begins_rather_than_inside() -> None:
    assert matched_spans("go", "Go to shelf: type the shelf") == [(0, 2)]
    assert matched_spans("shelf go", "Go to shelf") == [(0, 2), (6, 11)]
    assert matched_spans("eed", "Set max_speed") == [(10, 13)]
    assert matched_spans("speed", "Set max_speed") == [(8, 13)]
    assert matched_spans("drive", "Go to shelf") == []
    assert matched_spans("", "Go to shelf") == []
