"""Notices: in at most three rows below the header, over no alarm, STOP or question."""

from __future__ import annotations

from rich.cells import cell_len
from textual.notifications import SeverityLevel

from archo_tui.screen.widgets.bars import DURATIONS, Notice, NoticeLine, notice_text, with_newest
from tests.support.clock import seconds
from tests.support.console import FAST, Console, click, console


def row_of(op: Console, text: str) -> int:
    return next(row for row, line in enumerate(op.text.splitlines()) if text in line)


async def test_a_refusal_is_seen_for_8_s_or_until_its_cause_ends() -> None:
    async with console(*FAST) as op:
        before = row_of(op, "1 Battery")
        since = seconds()
        await op.press("u")
        assert "▲ nothing to undo" in op.text.splitlines()[1]
        assert row_of(op, "1 Battery") == before
        await op.until(lambda: "nothing to undo" not in op.text)
        assert 8 <= seconds() - since < 10

        op.app.clear_notifications()
        op.app.notify("it failed", severity="error")
        await op.press("u")
        assert (row_of(op, "nothing to undo"), row_of(op, "it failed")) == (1, 2)
        await op.until(lambda: "nothing to undo" not in op.text)
        assert row_of(op, "it failed") == 1

        op.app.clear_notifications()
        op.app.action_command("release")
        await op.settle()
        assert row_of(op, "not stopped") == 1
        await op.press("u", "ctrl+x")
        await op.until("STOPPED: look for the cause")
        await op.until(lambda: "not stopped" not in op.text)
        assert row_of(op, "STOPPED: look for the cause") == 1
        assert row_of(op, "nothing to undo") == 2


async def test_notices_are_above_dialogs_that_are_open_and_that_are_opened() -> None:
    async with console(*FAST) as op:
        await op.press("u", "ctrl+p")
        assert row_of(op, "nothing to undo") == 1
        op.app.show_message("something else")
        await op.settle()
        assert (row_of(op, "something else"), row_of(op, "nothing to undo")) == (1, 2)
        await op.pilot.resize_terminal(50, 15)
        await op.until(lambda: row_of(op, "something else") == 0)


async def test_a_notice_covers_nothing_of_a_question() -> None:
    async with console(*FAST, size=(40, 10)) as op:
        await op.press("ctrl+x")
        await op.until(lambda: op.app.view.snapshot.is_stopped)
        for size in ((40, 10), (50, 15), (80, 24)):
            await op.pilot.resize_terminal(*size)
            await op.press("R")
            lines = [row.strip("┃ ") for row in op.text.splitlines() if "┃" in row]
            asked = [row for row in lines if row]
            op.app.show_message("something to read " * 12)
            await op.settle()
            rows = [row.strip("┃ ") for row in op.text.splitlines()]
            assert [row for row in rows if row in asked] == asked
            assert "· something to read" in op.text
            op.app.clear_notifications()
            await op.press("escape")


async def test_a_notice_is_not_over_the_stop_button_which_is_pressed_through_it() -> None:
    async with console(*FAST, size=(40, 10)) as op:
        await op.press("2")
        op.app.show_message("something to read " * 12)
        await op.settle()
        button = op.app.query_one("#stop").region
        assert "STOP" in op.text.splitlines()[button.y]
        assert "something to read" in op.text

        await op.pilot.resize_terminal(50, 15)
        await op.settle()
        button, notice = op.app.query_one("#stop").region, op.app.main.query_one(NoticeLine)
        notice.styles.offset = 0, button.y
        await op.settle()
        assert notice.region.contains(button.x, button.y)
        click(op.app, button.x + 1, button.y)
        await op.until(lambda: op.app.view.snapshot.is_stopped)


def notice(text: str, severity: SeverityLevel = "warning") -> Notice:
    return Notice(text, severity, 0.0)


def test_graver_notices_stay_longer_and_a_refusal_for_8_s() -> None:
    assert DURATIONS["information"] < DURATIONS["warning"] == 8 < DURATIONS["error"]


def test_of_more_than_three_the_oldest_of_the_least_grave_goes_and_equal_ones_are_one() -> None:
    shown: list[Notice] = []
    for text, severity in (("lost", "error"), ("saved", "information"), ("sent", "information")):
        shown = with_newest(shown, notice(text, severity))  # type: ignore[arg-type]
    assert [one.text for one in shown] == ["sent", "saved", "lost"]
    for _ in range(2):
        shown = with_newest(shown, notice("refused"))
        assert [one.text for one in shown] == ["refused", "sent", "lost"]
    graver = [notice(text, "error") for text in ("c", "b", "a")]
    assert [one.text for one in with_newest(graver, notice("refused"))] == ["refused", "c", "b"]


def test_notices_have_glyphs_and_rows_and_a_long_one_alone_goes_on_below() -> None:
    words = " ".join(["word"] * 20)
    assert notice_text([notice("it failed", "error")], 20).plain == " ✗ it failed"
    several = [notice("refused"), notice("saved", "information"), notice(words)]
    *lines, last = notice_text(several, 30).plain.splitlines()
    assert lines == [" ▲ refused", " · saved"]
    assert (last[:3], last[-1]) == (" ▲ ", "…")
    assert notice_text([notice(words)], 120).plain.count("\n") == 0
    lines = notice_text([notice(words)], 30).plain.splitlines()
    assert len(lines) == 3
    assert max(map(len, lines)) <= 29
    assert lines[-1].endswith("…")


def test_a_long_notice_in_wide_characters_loses_none_of_them_between_lines() -> None:
    text = "电池电量过低请立即充电否则机器人会停在货架之间并且需要人工搬运"
    lines = notice_text([notice(text)], 30).plain.splitlines()
    assert max(map(cell_len, lines)) == 29
    assert "".join(line[3:] for line in lines) == text
