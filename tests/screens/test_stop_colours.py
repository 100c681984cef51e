"""STOP is red while it can be pressed, and STOPPED has one colour wherever it stands."""

from __future__ import annotations

import pytest
from rich.segment import Segment
from textual.color import Color

from archo_tui.screen.app import ArchoApp
from archo_tui.screen.terminal.themes import contrast
from tests.screens.test_contrast import THEMES, colours
from tests.support.console import send
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import StandingClock, stub_app

SIZES = (80, 24), (120, 36), (160, 48), (50, 15)


def segments(app: ArchoApp, text: str) -> list[Segment]:
    """The drawn pieces with that text in them, from above."""
    drawn = app.screen._compositor.render_strips()
    return [segment for strip in drawn for segment in strip if text in segment.text]


def stop_button(app: ArchoApp) -> Segment:
    stop = app.main.query_one("#stop")
    (found,) = [segment for segment in stop.render_line(0) if "STOP" in segment.text]
    return found


async def test_stop_is_red_until_stopped_has_the_colour_of_its_alarm() -> None:
    app = stub_app(STATES["normal"], StandingClock())
    async with app.run_test(size=(120, 36)) as pilot:
        quiet = Quiet(app)
        app.theme = THEMES[0]
        for size in SIZES:
            await pilot.resize_terminal(*size)
            await check_stop(app, quiet)
        await pilot.resize_terminal(120, 36)
        for app.theme in THEMES:
            await check_stop(app, quiet)
            app.tick()
            await quiet.settle()
            header, banner, motor = segments(app, "STOPPED")
            fronts = [Color.from_rich_color(one.style.color) for one in (header, banner, motor)]  # type: ignore[union-attr]
            assert fronts == [Color.parse(app.theme_variables["warn"])] * 3


async def check_stop(app: ArchoApp, quiet: Quiet) -> None:
    """STOP is red in each state but that of a stopped robot, where it has edges."""
    red = Color.parse(app.theme_variables["stopped"])
    for state in ("normal", "motor moving", "motor stop not confirmed", "battery empty"):
        app._on_snapshot(STATES[state])
        await quiet.settle()
        style = stop_button(app).style
        assert style is not None
        assert colours(style)[1] == red, state
    app._on_snapshot(STATES["motor stopped"])
    await quiet.settle()
    style = stop_button(app).style
    assert style is not None
    front, back = colours(style)
    assert back != red
    assert contrast(front, back) >= 4.5  # It can still be pressed.
    edges = {one.text for one in (*segments(app, "▏"), *segments(app, "▕"))}
    assert {"▏", "▕"} <= edges


async def test_a_banner_goes_across_the_whole_width_until_it_is_acknowledged() -> None:
    app = stub_app(STATES["motor stopped"], StandingClock())
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        app.tick()
        await quiet.settle()
        row = app.screen._compositor.render_strips()[1]
        assert "STOPPED: look for the cause" in row.text
        assert all(segment.style is not None and segment.style.reverse for segment in row)
        send(app, "a")
        await quiet.settle()
        row = app.screen._compositor.render_strips()[1]
        assert "STOPPED: look for the cause" in row.text
        assert not any(segment.style is not None and segment.style.reverse for segment in row)


async def test_without_colours_stop_is_the_strongest_contrast_until_the_robot_is_stopped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    app = stub_app(STATES["normal"], StandingClock())
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        style = stop_button(app).style
        assert style is not None
        assert contrast(*colours(style)) > 10
        app._on_snapshot(STATES["motor stopped"])
        await quiet.settle()
        style = stop_button(app).style
        assert style is not None
        assert 4.5 <= contrast(*colours(style)) < 10
