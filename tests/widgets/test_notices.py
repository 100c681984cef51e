"""Which notice is shown, for how long, and how it looks in a line."""

from __future__ import annotations

from rich.cells import cell_len

from archo_tui.widgets.notices import Notice, Notices, notice_text


def texts(notices: Notices, *times: float) -> list[str | None]:
    shown = [notices.update(time) for time in times]
    return [None if notice is None else notice.text for notice in shown]


def test_the_newest_of_the_gravest_notices_is_shown() -> None:
    notices = Notices()
    for text, severity in (("saved", 0), ("failed", 2), ("lost", 2), ("refused", 1)):
        notices.add(text, ("information", "warning", "error")[severity], 5)
    assert notices.update(0) == Notice("lost", "error", waiting=3)


def test_a_notice_goes_after_its_time() -> None:
    notices = Notices()
    notices.add("saved", "information", 5)
    assert texts(notices, 10, 14.9, 15) == ["saved", "saved", None]


def test_a_notice_behind_an_error_has_its_whole_time_afterwards() -> None:
    notices = Notices()
    notices.add("failed", "error", 5)
    assert texts(notices, 0) == ["failed"]
    notices.add("refused", "warning", 5)
    assert texts(notices, 4, 5, 9.9, 10) == ["failed", "refused", "refused", None]


def test_a_notice_that_waited_long_behind_errors_is_not_shown_any_more() -> None:
    notices = Notices()
    notices.add("refused", "warning", 5)
    for second in (0, 4, 8):
        notices.add(f"failed at {second}", "error", 5)
        assert texts(notices, second) == [f"failed at {second}"]
    assert texts(notices, 12.9, 13) == ["failed at 8", None]


def test_an_equal_notice_is_shown_once_with_its_whole_time() -> None:
    notices = Notices()
    notices.add("refused", "warning", 5)
    assert texts(notices, 0) == ["refused"]
    notices.add("refused", "warning", 5)
    assert notices.update(4) == Notice("refused", "warning")
    assert texts(notices, 8.9, 9) == ["refused", None]


def test_a_dismissed_notice_makes_room_for_the_next() -> None:
    notices = Notices()
    notices.add("refused", "warning", 5)
    notices.add("failed", "error", 5)
    notices.dismiss()
    assert texts(notices, 0) == ["refused"]
    notices.dismiss()
    notices.dismiss()
    assert texts(notices, 0) == [None]


def test_a_glyph_tells_the_severity_and_a_number_how_many_wait() -> None:
    assert notice_text(Notice("it failed", "error", 2), 20).plain == " ✗ it failed     +2 "
    assert notice_text(Notice("refused", "warning"), 20).plain == " ▲ refused"
    assert notice_text(Notice("saved", "information"), 20).plain == " · saved"


def test_a_long_notice_goes_on_below_and_a_very_long_one_is_cut() -> None:
    words = " ".join(["word"] * 20)
    assert notice_text(Notice(words, "error"), 120).plain.count("\n") == 0
    lines = notice_text(Notice(words, "error", 1), 30).plain.splitlines()
    assert len(lines) == 3
    assert max(map(len, lines)) == 30
    assert lines[0].endswith(" +1 ")
    assert lines[-1].endswith("…")


def test_a_long_notice_in_wide_characters_loses_none_of_them_between_lines() -> None:
    text = "电池电量过低请立即充电否则机器人会停在货架之间并且需要人工搬运"
    lines = notice_text(Notice(text, "error"), 30).plain.splitlines()
    assert max(map(cell_len, lines)) == 29
    assert "".join(line[3:] for line in lines) == text


def test_a_notice_in_two_lines_is_one_notice() -> None:
    notices = Notices()
    notices.add("Traceback:\n  it failed", "error", 5)
    assert texts(notices, 0) == ["Traceback: it failed"]
