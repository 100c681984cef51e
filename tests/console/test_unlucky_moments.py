"""Keys and clicks that come while a screen is built, while it goes, and when it has just gone."""

from __future__ import annotations

import asyncio
from contextvars import Context
from unittest.mock import patch

import pytest
from textual import events
from textual.app import App, ComposeResult
from textual.errors import NoWidget
from textual.geometry import Size
from textual.widgets import Input

from archo_tui.screen.choose import ChoiceRows
from archo_tui.screen.commands.alarms import AlarmList
from archo_tui.screen.commands.help import Help
from archo_tui.screen.commands.palette import CommandPalette
from archo_tui.screen.main import MainScreen
from archo_tui.screen.widgets.bars import NoticeLine
from archo_tui.screen.widgets.field import Button
from tests.support.console import FAST, Console, click, console


async def stop_works(op: Console) -> None:
    """And with it the console."""
    await op.press("ctrl+x")
    await op.until(lambda: any("STOPPED" in alarm.text for alarm in op.app.view.alarms))


async def read_something(op: Console) -> NoticeLine:
    """A notice that has just come."""
    op.app.show_message("something to read")
    await op.until("something to read")
    return op.app.screen.query_one(NoticeLine)


async def test_palette_and_help_over_each_other_go_as_they_came() -> None:
    async with console(*FAST) as op:
        for _ in range(3):
            await op.press("ctrl+p")
            op.send("escape")
            while op.app.screen is not op.app.main:
                await asyncio.sleep(0)
        op.app.action_command_palette()
        await op.until(lambda: isinstance(op.app.screen, CommandPalette))
        await op.press("escape")
        assert op.app.screen is op.app.main

        await op.press("ctrl+p", "f1", "ctrl+p")
        assert "Keys" in op.text
        await op.press("escape")
        await op.until(lambda: isinstance(op.app.screen, CommandPalette))
        await op.press("escape")
        assert op.app.screen is op.app.main

        await op.press("ctrl+p")
        click(op.app, 0, 0)
        op.send("f1")
        await op.until(lambda: isinstance(op.app.screen, Help))
        await op.settle()
        assert "Keys" in op.text
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)

        await op.press("ctrl+p")
        palette = op.app.screen
        await op.press("f1")
        await op.until(lambda: isinstance(op.app.screen, Help))
        palette.dismiss()
        await op.settle()
        assert "Keys" in op.text
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)

        await op.press("f1")
        help_screen = op.app.screen
        await op.press("escape")
        assert isinstance(help_screen, Help)
        assert not help_screen.children
        help_screen._draw()

        op.send("ctrl+p", "pagedown", "pageup")
        await op.settle()
        await op.type("zzz")
        await op.press("pagedown", "pageup", "end", "home", "enter", "escape")
        await op.press("escape")
        assert op.app.screen is op.app.main

        await op.press("ctrl+p")
        rows = op.app.screen.query_one(ChoiceRows)
        x, y = rows.region.offset
        await op.type("zzz")
        for at in (y, y + 2, 999):  # 999: beyond the terminal
            rows.post_message(events.Click(rows, x, at, 0, 0, 1, False, False, False, x, at))
        await op.settle()
        assert isinstance(op.app.screen, CommandPalette)
        await stop_works(op)


async def test_a_dialog_follows_a_size_that_the_screen_behind_it_got_first() -> None:
    async with console(*FAST) as op:
        await op.press("f1")
        size = op.app._size = Size(60, 20)
        event = events.Resize(size, size)  # Textual sends the same one to all screens.
        op.app.main.post_message(event)
        await op.settle()
        op.app.screen.post_message(event)
        await op.settle()
        assert op.app.screen.query_one(".dialog").region.right <= size.width


async def test_news_and_clicks_meet_a_screen_that_is_built_or_has_just_gone() -> None:
    async with console(*FAST) as op:
        notice = await read_something(op)
        x, y = notice.region.offset
        parent = notice.parent
        assert parent is not None
        notice._detach()  # as it is until the screen is drawn again
        assert op.app.screen.get_widget_and_offset_at(x + 1, y) == (None, None)
        notice._attach(parent)

        await op.press("escape", "escape")
        notice = await read_something(op)
        x, y = notice.region.offset
        for _ in range(4):
            click(op.app, x + 1, y)
        await op.until(lambda: "something to read" not in op.text)
        await stop_works(op)

        await op.press("escape", "escape")
        await stop_works(op)
        op.app.action_command("alarms")
        assert isinstance(op.app.screen, AlarmList)
        # From the loop, as the robot's are.
        Context().run(op.app._on_snapshot, op.app.view.snapshot)
        await op.settle()
        assert "STOPPED: look for the cause" in op.text
        await op.press("escape")
        assert not isinstance(op.app.screen, AlarmList)


async def test_two_sizes_of_the_terminal_do_not_chase_each_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    laid_out: list[Size] = []
    lay_out = MainScreen._refresh_layout

    def counted(screen: MainScreen, size: Size | None = None, scroll: bool = False) -> None:
        laid_out.append(screen.size)
        assert len(laid_out) < 100, "for ever"
        lay_out(screen, size, scroll)

    async with console(*FAST) as op:
        monkeypatch.setattr(MainScreen, "_refresh_layout", counted)
        for size in (Size(100, 30), Size(90, 30)):  # as they come when a window is dragged
            op.app.main.post_message(events.Resize(size, size))
            op.app.main.post_message(events.Print("something else", stderr=True))
        await op.settle()
        assert op.app.main.size == (120, 36)  # what the terminal is
        await stop_works(op)


async def test_a_panel_that_has_no_room_any_more_keeps_no_focus() -> None:
    async with console(*FAST, size=(160, 48)) as op:
        await op.press("7")
        assert op.focused_panel == 7
        await op.pilot.resize_terminal(80, 24)
        await op.until(lambda: op.focused_panel == 4)

        await op.pilot.resize_terminal(160, 48)
        await op.press("8", "g")
        await op.pilot.resize_terminal(80, 24)
        await op.press("escape")
        assert op.focused_panel == 4

        await op.pilot.resize_terminal(160, 48)
        await op.press("5")
        await op.pilot.resize_terminal(80, 24)
        click(op.app, 130, 40)
        await op.settle()
        assert op.focused_panel == 5


async def test_a_field_or_a_list_keeps_the_focus_in_a_tiny_or_hidden_terminal() -> None:
    async with console(*FAST) as op:
        await op.press("5")
        with patch.object(op.app.main, "get_widget_at", side_effect=NoWidget):
            click(op.app, 3, 3)
            await op.settle()
        assert op.focused_panel == 5

        await op.press("g", "1")
        op.app.post_message(events.AppBlur())
        await op.settle()
        await op.pilot.resize_terminal(80, 24)
        await op.settle()
        op.app.post_message(events.AppFocus())
        await op.settle()
        await op.press("2")
        assert op.app.query_one("#goal-0", Input).value == "12"


class Narrow(App[None]):
    """A terminal in which a button may have no cell."""

    CSS = "Button { min-width: 0; width: 2; line-pad: 1; }"  # as in style.tcss

    def compose(self) -> ComposeResult:
        yield Button("Release", lambda: None, id="release")


async def test_a_button_without_a_cell_for_its_label_is_drawn() -> None:
    app = Narrow()
    async with app.run_test(size=(20, 5)) as pilot:
        for width, shows in ((2, False), (1, False), (0, False), (12, True)):
            app.query_one(Button).styles.width = width
            await pilot.pause()
            assert ("Release" in app.screen._compositor.render_strips()[0].text) is shows
