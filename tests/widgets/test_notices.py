"""Which notices are shown, and how they look in at most three rows."""

from __future__ import annotations

from rich.cells import cell_len
from textual.notifications import SeverityLevel

from archo_tui.screen.widgets.bars import DURATIONS, Notice, notice_text, with_newest


def notice(text: str, severity: SeverityLevel = "warning") -> Notice:
    return Notice(text, severity, 0.0)


def test_graver_notices_stay_longer_and_a_refusal_for_8_s() -> None:
    assert DURATIONS["information"] < DURATIONS["warning"] == 8 < DURATIONS["error"]


def test_of_more_than_three_the_oldest_of_the_least_grave_goes() -> None:
    shown: list[Notice] = []
    for text, severity in (("lost", "error"), ("saved", "information"), ("sent", "information")):
        shown = with_newest(shown, notice(text, severity))  # type: ignore[arg-type]
    assert [one.text for one in shown] == ["sent", "saved", "lost"]
    shown = with_newest(shown, notice("refused"))
    assert [one.text for one in shown] == ["refused", "sent", "lost"]


def test_the_newest_is_shown_even_if_all_others_are_graver() -> None:
    shown = [notice(text, "error") for text in ("c", "b", "a")]
    assert [one.text for one in with_newest(shown, notice("refused"))] == ["refused", "c", "b"]


def test_an_equal_notice_is_shown_once() -> None:
    shown = with_newest([notice("failed", "error"), notice("refused")], notice("refused"))
    assert [one.text for one in shown] == ["refused", "failed"]


def test_a_glyph_tells_the_severity() -> None:
    assert notice_text([notice("it failed", "error")], 20).plain == " ✗ it failed"
    several = [notice("refused"), notice("saved", "information")]
    assert notice_text(several, 20).plain == " ▲ refused\n · saved"


def test_a_long_notice_goes_on_below_and_a_very_long_one_is_cut() -> None:
    words = " ".join(["word"] * 20)
    assert notice_text([notice(words)], 120).plain.count("\n") == 0
    lines = notice_text([notice(words)], 30).plain.splitlines()
    assert len(lines) == 3
    assert max(map(len, lines)) <= 29
    assert lines[-1].endswith("…")


def test_several_have_a_row_each() -> None:
    words = " ".join(["word"] * 20)
    lines = notice_text([notice(words), notice("b"), notice("c")], 30).plain.splitlines()
    assert [line[:3] for line in lines] == [" ▲ "] * 3
    assert lines[0].endswith("…")


def test_a_long_notice_in_wide_characters_loses_none_of_them_between_lines() -> None:
    text = "电池电量过低请立即充电否则机器人会停在货架之间并且需要人工搬运"
    lines = notice_text([notice(text)], 30).plain.splitlines()
    assert max(map(cell_len, lines)) == 29
    assert "".join(line[3:] for line in lines) == text
