"""What is typed into a field acts in its order, and its keys stand in the footer."""

from __future__ import annotations

import pytest
from textual import events
from textual._compositor import Compositor
from textual.geometry import Size
from textual.screen import Screen

from archo_tui.screen.commands.parameters import EditParameter
from archo_tui.screen.widgets.bars import FooterKey, footer
from archo_tui.screen.widgets.field import Field
from tests.support.console import FAST, PANEL_KEYS, console


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


COMMANDS = [
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
    line = footer(COMMANDS[1:], width, "^p", keys).plain
    assert line.partition("  ^p")[0].rstrip() == shown.rstrip()
