"""Where the focus is at the start, and what keys do there."""

from __future__ import annotations

import pytest

from archo_tui.screen.widgets.field import Field
from tests.support.console import FAST, LONG, PANEL_KEYS, console
from tests.support.front import front
from tests.support.states import NORMAL
from tests.support.stub import StandingClock, stub_app


async def test_at_the_start_letters_are_commands_and_the_footer_shows_them() -> None:
    async with console(*LONG, in_field=True) as op:
        assert "enter Go" in op.text
        assert "esc Leave  ^c Cancel  ^x STOP  r Reset  ? Help  q Quit" in op.text
        assert f"{PANEL_KEYS} Panels" not in op.text
        await op.press("question_mark")
        assert "Here, in Go to shelf" in op.text
        await op.press("escape", "1")
        assert "q Quit" not in op.text.splitlines()[-1]  # It would be text behind the 1.
        await op.press("backspace")
        assert "q Quit" in op.text.splitlines()[-1]
        await op.press("ctrl+x")
        await op.until("STOPPED")


async def test_at_the_start_a_number_and_enter_drive_and_enter_alone_does_not() -> None:
    async with console(*FAST, in_field=True) as op:
        assert isinstance(op.app.focused, Field)
        await op.press("enter", "enter")
        assert op.app.view.snapshot.goal is None
        assert len(op.app.screen_stack) == 1
        await op.press("1", "2", "enter")
        await op.until("12 arrived")

        await op.press("escape")
        assert op.focused_panel == 4
        assert f"{PANEL_KEYS} Panels" in op.text
        await op.press("5")
        assert op.focused_panel == 5


@pytest.mark.parametrize("size", [(79, 40), (50, 15), (120, 19)])
async def test_a_field_out_of_sight_does_not_have_the_focus(size: tuple[int, int]) -> None:
    async with front(NORMAL, StandingClock(), size=size, in_field=True) as it:
        assert not isinstance(it.app.focused, Field)
        assert it.focused_panel == 4


async def test_typing_in_a_field_that_went_out_of_sight_shows_it() -> None:
    async with front(NORMAL, StandingClock(), in_field=True) as it:
        assert "Go to shelf" not in await it.resize(50, 12)
        shown = await it.press("7")
        assert "Shelf 7" in shown
        assert "STOP" in shown


async def test_a_console_that_watches_starts_in_a_list() -> None:
    async with console(*FAST, watch=True) as op:
        assert not op.app.main.starts_in_field
        assert op.focused_panel == 4


def test_a_form_that_takes_text_does_not_have_the_focus_at_the_start() -> None:
    """In such a field no letter would be a command."""
    panel = stub_app(NORMAL).main.goal
    assert panel.first_field is panel.fields[0]
    panel.fields[0]._takes = ""
    assert panel.first_field is None
