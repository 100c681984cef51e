"""What does nothing looks so: by more than its colour, and with 16 and 256 colours too."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from rich.color import Color, ColorSystem
from rich.style import Style
from textual.app import App

from archo_tui.screen.terminal.themes import contrast
from tests.screens.test_contrast import THEMES, colours
from tests.support.console import screen_text, send
from tests.support.quiet import Quiet
from tests.support.states import NORMAL, STATES
from tests.support.stub import StubRobot, stub_app

RED = (1, 9)  # of 16 colours, dark and bright


def styles(app: App[Any], text: str) -> Iterator[Style]:
    """How each part of the screen is written that has the text in it."""
    for strip in app.screen._compositor.render_strips():
        yield from (one.style for one in strip if text in one.text and one.style is not None)


async def test_a_key_that_does_nothing_is_not_bold_and_one_that_does_is() -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(120, 36)):
        await Quiet(app).settle()
        assert all(style.bold for style in styles(app, "^s"))
        assert list(styles(app, "^s"))
        (undo,) = styles(app, "u undo")
        assert not undo.bold


async def test_who_only_watches_sees_stop_and_every_key_of_a_border_dimmed() -> None:
    app = stub_app(STATES["motor moving"])
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    robot.watching = True
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        app.tick()
        await quiet.settle()
        for dead in ("^x stop", "enter go", "^c cancel", "c charge", "r reset", "enter edit"):
            (style,) = styles(app, dead)
            assert not style.bold, dead
        for live in ("filter", "level"):
            assert list(styles(app, live))
        for button in ("#stop", "#go", "#cancel", "#reset"):
            assert app.main.query_one(button).has_class("-blocked"), button
        for stopped in (False, True):
            robot.put(STATES["motor stopped" if stopped else "motor moving"])
            await quiet.settle()
            (style,) = (s for s in styles(app, "STOP ") if s.color and not s.bold)
            front, back = colours(style)
            assert contrast(front, back) < 6


async def test_a_robots_stop_is_red_with_few_colours_too() -> None:
    app = stub_app(STATES["motor moving"])
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        for app.theme in THEMES:
            await quiet.settle()
            app.tick()
            await quiet.settle()
            stop = app.main.query_one("#stop").rich_style
            assert stop.bgcolor is not None
            for system in (ColorSystem.EIGHT_BIT, ColorSystem.STANDARD):
                seen = stop.bgcolor.downgrade(system)
                red, green, blue = seen.get_truecolor()
                assert red > 100
                assert max(green, blue) < red / 3
            assert seen.number in RED


async def test_of_16_colours_labels_are_below_text_and_borders_below_labels(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    app = stub_app(NORMAL)
    assert app.console.color_system == "standard"
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        names = ("foreground", "quiet", "edge")
        found = [app.theme_variables[name] for name in names]
        numbers = [Color.parse(one.lower()).downgrade(ColorSystem.STANDARD).number for one in found]
        assert numbers == [15, 7, 8]


async def test_state_and_banner_stay_lit_above_a_dialog_and_follow_the_robot() -> None:
    app = stub_app(STATES["motor stopped"], size=(80, 24))
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    async with app.run_test(size=(80, 24)) as pilot:
        quiet = Quiet(app)
        await quiet.settle()
        send(app, "ctrl+p")
        await quiet.settle()
        for text in ("✗ STOPPED", "STOPPED: look for the cause"):
            ((front, back),) = {colours(style) for style in styles(app, text)}
            assert contrast(front, back) >= 4.5, text
        robot.put(STATES["motor moving"])
        await quiet.settle()
        assert "✗ STOPPED" not in screen_text(app).splitlines()[0]
        await pilot.resize_terminal(80, 15)
        await quiet.settle()
        assert "online" not in screen_text(app)  # A small terminal is left to the dialog.
