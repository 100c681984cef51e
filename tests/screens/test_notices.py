"""Notices on the screen: one line below the header, over everything, that hides no alarm."""

from __future__ import annotations

from archo_tui.keyed_app import HELD
from archo_tui.widgets.notices import NoticeLine
from tests.support.clock import seconds
from tests.support.console import FAST, Console, click, console


def row_of(op: Console, text: str) -> int:
    return next(row for row, line in enumerate(op.text.splitlines()) if text in line)


async def test_a_refusal_is_in_the_second_row_for_its_time() -> None:
    async with console(*FAST) as op:
        op.app.NOTIFICATION_TIMEOUT = 5  # type: ignore[misc]
        before = row_of(op, "1 Battery")
        await op.press("u")
        assert "▲ nothing to undo" in op.text.splitlines()[1]
        assert row_of(op, "1 Battery") == before
        await op.until(lambda: "nothing to undo" not in op.text)


async def test_a_notice_makes_room_for_an_alarm() -> None:
    async with console(*FAST) as op:
        await op.press("u")
        assert row_of(op, "nothing to undo") == 1
        await op.press("ctrl+x")
        await op.until("STOPPED: look for the cause")
        await op.settle()
        assert row_of(op, "STOPPED: look for the cause") == 1
        assert row_of(op, "nothing to undo") == 2


async def test_a_notice_is_shown_over_dialogs_that_are_open_and_that_are_opened() -> None:
    async with console(*FAST) as op:
        await op.press("u", "ctrl+p")
        assert row_of(op, "nothing to undo") == 1
        op.app.show_message("something else")
        op.app.show_message("and this")
        await op.settle()
        assert "▲ nothing to undo" in op.text.splitlines()[1]
        assert op.text.splitlines()[1].endswith("+2 ")
        await op.pilot.resize_terminal(50, 15)
        await op.until(lambda: row_of(op, "nothing to undo") == 0)


async def test_the_stop_button_is_pressed_through_a_notice() -> None:
    async with console(*FAST, size=(50, 15)) as op:
        await op.press("2")
        op.app.show_message("something to read")
        await op.settle()
        button, notice = op.app.query_one("#stop"), op.app.main.query_one(NoticeLine)
        notice.styles.offset = 0, button.region.y
        await op.settle()
        assert notice.region.contains(button.region.x, button.region.y)
        click(op.app, button.region.x + 1, button.region.y)
        await op.until(lambda: op.app.view.snapshot.is_stopped)


async def test_a_double_click_on_a_notice_does_nothing_to_what_lies_below() -> None:
    async with console(*FAST) as op:
        op.app.has_sent = False
        op.app.update_screen()
        await op.settle()
        column = op.text.splitlines()[1].index("charge the battery")
        op.app.show_message("something that is so long that it is over the hint to charge")
        await op.settle()
        click(op.app, column, 1)
        click(op.app, column, 1)
        await op.until("c charge the battery")
        await op.at(seconds() + 2.0)
        assert not [event for event in op.app.view.snapshot.events if event.level == "YOU"]
        region, since = op.app._gone_notice
        op.app._gone_notice = region, since - HELD
        click(op.app, column, 1)
        await op.until(lambda: op.app.view.snapshot.battery.charging)


async def test_a_double_click_closes_one_of_two_notices() -> None:
    async with console(*FAST) as op:
        op.app.show_message("read this first")
        op.app.show_message("and this")
        await op.settle()
        click(op.app, 5, 1)
        click(op.app, 5, 1)
        await op.until("read this first")
        assert "and this" not in op.text
