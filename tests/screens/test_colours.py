"""Everything on the screen can be read, STOP is seen first, and what does nothing looks so.

In every theme that we promise it for, and with 16 and 256 colours or none too. Notices: in at most
three rows below the header, over no alarm, STOP or question.
"""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from rich.cells import cell_len
from rich.color import Color as RichColor
from rich.color import ColorSystem
from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.notifications import SeverityLevel
from textual.strip import Strip
from textual.theme import BUILTIN_THEMES

from archo_tui.screen.terminal.themes import HIGH_CONTRAST, contrast, derive_tones
from archo_tui.screen.widgets.bars import DURATIONS, Notice, NoticeLine, notice_text, with_newest
from archo_tui.screen.widgets.field import Button
from tests.support.clock import seconds
from tests.support.console import FAST, Console, click, console
from tests.support.front import Front, front
from tests.support.night import corners
from tests.support.states import STATES
from tests.support.stub import StandingClock, stub_app

TEXT, OFF = 4.5, 3.0  # as WCAG asks for text, and for what cannot be used
THEMES = ("textual-dark", "textual-light", "high-contrast")
RED = (1, 9)  # of 16 colours, dark and bright
EDIT = ("4", "home", "down", "down", "enter")


def colours(style: Style | None) -> tuple[Color, Color]:
    """What a style writes with, and on."""
    assert style is not None
    assert style.color is not None
    assert style.bgcolor is not None
    front, back = Color.from_rich_color(style.color), Color.from_rich_color(style.bgcolor)
    if style.dim:
        front = back.blend(front, 0.5)
    return (back, front) if style.reverse else (front, back)


def unreadable(it: Front, strips: Iterable[Strip]) -> list[tuple[str, float]]:
    """The texts of too little contrast, and how much they have."""
    off, found = Color.parse(it.app.theme_variables["off"]), []
    for segment in (segment for strip in strips for segment in strip):
        if segment.style is not None and any(letter.isalnum() for letter in segment.text):
            front, back = colours(segment.style)
            ratio = contrast(front, back)
            if ratio < (OFF if front == off else TEXT):
                found.append((segment.text, ratio))
    return found


def styles(it: Front, text: str) -> list[Style]:
    """How each part of the screen is written that has the text in it, from above."""
    segments = (segment for strip in it.strips for segment in strip)
    return [one.style for one in segments if text in one.text and one.style is not None]


def stop_button(it: Front) -> Segment:
    line = it.main.query_one("#stop").render_line(0)
    (found,) = [segment for segment in line if "STOP" in segment.text]
    return found


def filled(it: Front) -> list[str]:
    """The ids of the buttons that are filled with the accent's colour."""
    accent = Color.parse(it.app.theme_variables["primary-darken-2"])
    buttons = it.app.screen.query(Button)
    return [str(one.id) for one in buttons if one.styles.background.rgb == accent.rgb]


@pytest.mark.parametrize("name", THEMES)
def test_every_tone_can_be_read_on_every_background(name: str) -> None:
    theme = BUILTIN_THEMES.get(name, HIGH_CONTRAST)
    variables = {**theme.to_color_system().generate(), **(theme.variables or {})}
    tones = derive_tones(variables)
    for tone, least in (("quiet", TEXT), ("off", OFF), ("warn", TEXT), ("bad", TEXT)):
        for behind in ("background", "surface", "panel"):
            ratio = contrast(Color.parse(tones[tone]), Color.parse(variables[behind]))
            assert ratio >= least, (tone, behind)


@pytest.mark.parametrize("theme", corners(["textual-light"], ["textual-dark", "high-contrast"]))
async def test_every_text_can_be_read(theme: str) -> None:
    async with front(STATES["normal"], StandingClock()) as it:
        it.app.theme = theme
        for name, snapshot in STATES.items():
            it.app._on_snapshot(snapshot)
            await it.tick()
            assert unreadable(it, it.strips) == [], name


async def test_every_text_of_a_dialog_can_be_read_in_every_theme() -> None:
    async with front(clock=StandingClock()) as it:
        for state, keys in (
            ("normal", ("enter", "question_mark")),
            ("battery low and moving", ("A", "r")),
        ):
            await it.put(STATES[state])
            for key in keys:
                await it.press(key)
                for it.app.theme in THEMES:
                    await it.settle()
                    assert it.app.screen is not it.main
                    box = it.app.screen.children[0].region
                    inside = [s.crop(box.x, box.right) for s in it.strips[box.y : box.bottom]]
                    assert unreadable(it, inside) == [], it.app.theme
                await it.press("escape")


async def test_the_button_that_enter_presses_is_filled_and_a_dialog_has_one_empty_row() -> None:
    async with front(STATES["motor moving"], StandingClock()) as it:
        for keys, pressed in ((EDIT, "submit"), (("4", "ctrl+s"), ""), (("q",), "answer-0")):
            await it.write(*keys)
            box = it.app.screen.children[0].region
            rows = it.text.splitlines()[box.y + 1 : box.bottom - 1]
            inside = [row[box.x + 1 : box.right - 1].strip() for row in rows]
            assert inside.count("") <= 1, inside
            assert not pressed or filled(it) == [pressed]
            if keys == EDIT:
                await it.press("tab")  # Enter now presses the button that has the focus.
                assert filled(it) == ["leave"]
                await it.press("shift+tab")
                assert filled(it) == ["submit"]
            await it.press("escape")


async def test_who_only_watches_sees_stop_and_every_key_of_a_border_dimmed() -> None:
    async with front(STATES["motor moving"]) as it:
        keys = styles(it, "^s")
        assert keys
        assert all(style.bold for style in keys)
        (undo,) = styles(it, "u undo")  # There is nothing to undo.
        assert not undo.bold
        it.robot.watching = True
        await it.tick()
        for dead in ("^x stop", "enter go", "^c cancel", "c charge", "r reset", "enter edit"):
            (style,) = styles(it, dead)
            assert not style.bold, dead
        for live in ("filter", "level"):
            assert styles(it, live)
        for button in ("#stop", "#go", "#cancel", "#reset"):
            assert it.main.query_one(button).has_class("-blocked"), button
        for state in ("motor moving", "motor stopped"):
            await it.put(STATES[state])
            (style,) = (s for s in styles(it, "STOP ") if s.color and not s.bold)
            assert contrast(*colours(style)) < 6


async def test_of_16_colours_labels_are_below_text_and_borders_below_labels(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    app = stub_app(STATES["normal"])
    assert app.console.color_system == "standard"
    async with app.run_test(size=(120, 36)) as pilot:
        await pilot.pause()
        found = [app.theme_variables[name] for name in ("foreground", "quiet", "edge")]
        numbers = [RichColor.parse(c.lower()).downgrade(ColorSystem.STANDARD).number for c in found]
        assert numbers == [15, 7, 8]


async def test_a_banner_goes_across_until_acknowledged_and_stays_lit_above_a_dialog() -> None:
    async with front(STATES["motor stopped"], size=(80, 24)) as it:
        await it.tick()
        for is_new in (True, False):
            row = it.strips[1]
            assert "STOPPED: look for the cause" in row.text
            assert {s.style.reverse or False for s in row if s.style is not None} == {is_new}
            await it.press("a")
        await it.press("ctrl+p")
        for text in ("✗ STOPPED", "STOPPED: look for the cause"):
            ((front_colour, back),) = {colours(style) for style in styles(it, text)}
            assert contrast(front_colour, back) >= 4.5, text
        shown = await it.put(STATES["motor moving"])
        assert "✗ STOPPED" not in shown.splitlines()[0]
        assert "online" not in await it.resize(80, 15)  # A small terminal is left to the dialog.


async def test_stop_is_red_until_stopped_has_the_colour_of_its_alarm() -> None:
    async with front(STATES["normal"], StandingClock()) as it:
        it.app.theme = THEMES[0]
        for size in ((50, 15), (120, 36)):
            await it.resize(*size)
            await check_stop(it)
        for it.app.theme in THEMES:
            await check_stop(it)
            await it.tick()
            fronts = [Color.from_rich_color(style.color) for style in styles(it, "STOPPED")]
            warn = Color.parse(it.app.theme_variables["warn"])
            assert fronts == [warn] * 3  # in the header, the banner and the panel


async def check_stop(it: Front) -> None:
    """STOP is red in each state but that of a stopped robot, where it has edges."""
    red = Color.parse(it.app.theme_variables["stopped"])
    for state in ("normal", "motor moving", "motor stop not confirmed", "battery empty"):
        it.app._on_snapshot(STATES[state])
        await it.settle()
        assert colours(stop_button(it).style)[1] == red, state
    few = it.main.query_one("#stop").rich_style.bgcolor
    assert few is not None
    for system in (ColorSystem.EIGHT_BIT, ColorSystem.STANDARD):
        seen = few.downgrade(system)
        channels = seen.get_truecolor()
        assert channels[0] > 100
        assert max(channels[1:]) < channels[0] / 3
    assert seen.number in RED
    it.app._on_snapshot(STATES["motor stopped"])
    await it.settle()
    front_colour, back = colours(stop_button(it).style)
    assert back != red
    assert contrast(front_colour, back) >= 4.5  # It can still be pressed.
    assert styles(it, "▏")
    assert styles(it, "▕")


async def test_without_colours_stop_is_the_strongest_contrast_until_the_robot_is_stopped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    async with front(STATES["normal"], StandingClock()) as it:
        assert contrast(*colours(stop_button(it).style)) > 10
        it.app._on_snapshot(STATES["motor stopped"])
        await it.settle()
        assert 4.5 <= contrast(*colours(stop_button(it).style)) < 10


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


def test_of_four_notices_the_oldest_of_the_least_grave_goes_equal_ones_are_one() -> None:
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
