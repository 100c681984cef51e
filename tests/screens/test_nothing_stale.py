"""What stands on the terminal, after parts of it were drawn anew, is what the whole would be."""

from __future__ import annotations

import random
from typing import Any

import pytest
from textual._compositor import ChopsUpdate, Compositor
from textual.app import App
from textual.screen import Screen

from archo_tui.robot.state.events import Event
from archo_tui.screen.widgets.panel import Panel
from tests.support.clock import TIME
from tests.support.console import click, screen_text, send
from tests.support.night import corners
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import StubRobot, stub_app

Cells = list[tuple[str, str]]
_DRAW = Screen._compositor_refresh
_KEYS = [*"12345678", *["tab", "shift+tab"] * 4, *["down", "up"] * 2, "end", "home", "h", "escape"]


@pytest.fixture(autouse=True)
def _drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here it counts what is drawn."""
    monkeypatch.setattr(Screen, "_compositor_refresh", _DRAW)


def picture(compositor: Compositor) -> list[Cells]:
    """Each character of the screen, and how it looks."""
    return [
        [(char, str(segment.style)) for segment in strip for char in segment.text]
        for strip in compositor.render_strips()
    ]


class Terminal:
    """Keeps what was drawn, until it is drawn over."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.cells: list[Cells] = []
        self.parts = 0
        part, whole = Compositor.render_partial_update, Compositor.render_full_update

        def draw_part(compositor: Compositor) -> ChopsUpdate | None:
            update = part(compositor)
            if update is not None:
                self.parts += 1
                drawn = picture(compositor)
                for y, start, end in update.spans:
                    self.cells[y][start:end] = drawn[y][start:end]
            return update

        def draw_all(compositor: Compositor, simplify: bool = False) -> Any:
            update = whole(compositor, simplify)
            self.cells = picture(compositor)
            return update

        monkeypatch.setattr(Compositor, "render_partial_update", draw_part)
        monkeypatch.setattr(Compositor, "render_full_update", draw_all)

    def shows(self, app: App[Any]) -> bool:
        """True when it shows what an app draws whose widgets have forgotten what they drew."""
        for widget in app.screen.walk_children(with_self=True):
            widget._styles_cache.clear()  # type: ignore[attr-defined]
        compositor: Any = app.screen._compositor
        return self.cells == picture(compositor)


SIZES = [(80, 24), (120, 36), (160, 48)]


@pytest.mark.parametrize(
    ("size", "steps"), corners([((80, 24), 20)], [(size, 80) for size in SIZES])
)
async def test_nothing_stays_of_where_the_focus_was(
    monkeypatch: pytest.MonkeyPatch, size: tuple[int, int], steps: int
) -> None:
    terminal, choose = Terminal(monkeypatch), random.Random(size[0])
    app = stub_app(STATES["normal"], size=size)
    async with app.run_test(size=size):
        quiet = Quiet(app)
        await quiet.settle()
        for _ in range(steps):
            if choose.random() < 0.3:
                panel = choose.choice([p for p in app.screen.query(Panel) if p.region])
                width, height = panel.region.size
                x, y = choose.randrange(width), choose.choice((0, height // 2, height - 1))
                click(app, panel.region.x + x, panel.region.y + y)
                what = f"a click on {panel.id} at {x}, {y}"
            else:
                send(app, what := choose.choice(_KEYS))
            await quiet.settle()
            if app.screen is not app.main:  # a dialog, by a click on what has the cursor
                send(app, "escape")
                await quiet.settle()
            assert terminal.shows(app), what
    assert terminal.parts > steps // 3  # a key and what it changes are drawn at once


async def test_the_panel_with_the_focus_can_be_told_and_what_in_it() -> None:
    def look(number: int) -> Cells:
        region = next(p.region for p in app.screen.query(Panel) if p.number == number)
        compositor: Any = app.screen._compositor
        lines = picture(compositor)[region.y : region.bottom]
        return [cell for line in lines for cell in line[region.x : region.right]]

    app = stub_app(STATES["normal"])
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)

        async def after(key: str) -> dict[int, Cells]:
            send(app, key)
            await quiet.settle()
            return {number: look(number) for number in (2, 4, 5)}

        parameters, motor = await after("4"), await after("2")
        assert "┏" in [char for char, _ in parameters[4]]
        assert "┏" not in [char for char, _ in parameters[2]]
        assert "┏" in [char for char, _ in motor[2]]
        assert "┏" not in [char for char, _ in motor[4]]
        assert any("reverse" in style for _, style in parameters[4])
        assert not any("reverse" in style for _, style in motor[4])
        drawn = [look(number) for number in range(1, 9)]
        for _ in range(10):
            send(app, "tab")
            await quiet.settle()
            before, drawn = drawn, [look(number) for number in range(1, 9)]
            assert drawn != before, app.focused


@pytest.mark.parametrize("size", corners(SIZES[:1], SIZES[1:]))
async def test_a_list_that_grows_shows_all_of_it_and_then_scrolls(
    monkeypatch: pytest.MonkeyPatch, size: tuple[int, int]
) -> None:
    terminal = Terminal(monkeypatch)
    app = stub_app(STATES["normal"]._replace(events=()), size=size)
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    events: tuple[Event, ...] = ()
    async with app.run_test(size=size):
        quiet = Quiet(app)
        await quiet.settle()
        rows = app.main.events.focus_target
        for number in range(2 * rows.size.height):
            event = Event(TIME + number, "WARN", "node", f"line {'x' * number}", number=number)
            events = (*events, event)
            robot.put(robot.snapshot._replace(events=events))
            await quiet.settle()
            assert terminal.shows(app), number
            shown = screen_text(app)
            newest = min(number + 1, rows.size.height)
            assert all(f"line {'x' * n}" in shown for n in range(number - newest + 1, number + 1))
        assert rows.show_vertical_scrollbar
        send(app, "6", "end")
        await quiet.settle()
        assert terminal.shows(app)
        assert "line  " in screen_text(app)
