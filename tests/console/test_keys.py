"""Focus, keys, help: the keyboard leads everywhere and back."""

from __future__ import annotations

from textual.widgets import Input

from tests.support.console import FAST, console


async def test_numbers_and_tab_walk_through_the_panels() -> None:
    async with console(*FAST) as op:
        for number in "12456":
            await op.press(number)
            assert op.focused_panel == int(number)
        await op.press("1")
        seen = []
        for _ in range(9):
            seen.append(op.focused_panel)
            await op.press("tab")
        assert seen == [1, 2, 2, 3, 3, 3, 4, 5, 6]


async def test_escape_leads_out_of_a_field_to_where_the_focus_was() -> None:
    async with console(*FAST) as op:
        await op.press("6", "g", "1", "escape")
        assert op.app.focused is not None
        assert op.app.focused.id == "event-list"
        assert op.app.query_one("#shelf", Input).value == "1"


async def test_letters_are_text_while_typing() -> None:
    async with console(*FAST) as op:
        await op.press("g")
        await op.type("rqac1?")
        assert op.app.query_one("#shelf", Input).value == "rqac1?"
        assert op.app.screen is op.app.main


async def test_letters_do_nothing_behind_a_dialog() -> None:
    async with console(*FAST) as op:
        await op.press("4", "ctrl+end", "enter")
        await op.until("ticks_per_revolution is read-only")
        await op.press("r", "c", "q")
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)
        await op.press("a")
        await op.until("no alarm to acknowledge")  # whatever r and c did is done by now
        assert "15 420 ticks" in op.text
        assert not [event for event in op.app.view.snapshot.events if event.level == "YOU"]


async def test_help_lists_every_command_with_its_key() -> None:
    async with console(*FAST, size=(120, 60)) as op:
        await op.press("question_mark")
        await op.until("Keys")
        for command in op.app.registry:
            assert command.help.split(" (")[0][:40] in op.text
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)


async def test_a_command_that_cannot_run_says_why() -> None:
    async with console(*FAST) as op:
        await op.press("R")
        await op.until("the robot is not stopped")


async def test_events_show_more_levels_on_demand() -> None:
    async with console(*FAST) as op:
        assert "Dashboard sees" not in op.text
        await op.press("6", "l")
        await op.until("Dashboard sees: ")
        await op.until("INFO and above")
