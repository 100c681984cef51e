"""The first picture is drawn once, news lay nothing out anew, nothing stale stays or is kept."""

from __future__ import annotations

import gc
import random
from itertools import count
from typing import Any
from weakref import WeakSet

import pytest
from textual._compositor import ChopsUpdate, Compositor
from textual._styles_cache import StylesCache
from textual.screen import Screen

from archo_tui.robot.state.events import Event
from archo_tui.screen import main
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.panel import Panel
from tests.support.clock import TIME
from tests.support.console import FAST, console
from tests.support.front import Front, front
from tests.support.night import corners
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import StandingClock, stub_app

Cells = list[tuple[str, str]]
_DRAW = Screen._compositor_refresh
_KEYS = [*"12345678", *["tab", "shift+tab"] * 4, *["down", "up"] * 2, "end", "home", "h", "escape"]
SIZES = [(80, 24), (120, 36), (160, 48)]


@pytest.fixture(autouse=True)
def _drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here it counts what is drawn."""
    monkeypatch.setattr(Screen, "_compositor_refresh", _DRAW)


def cells(strips: list[Any]) -> list[Cells]:
    """Each character, and how it looks."""
    return [
        [(char, str(segment.style)) for segment in strip for char in segment.text]
        for strip in strips
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
                drawn = cells(compositor.render_strips())
                for y, start, end in update.spans:
                    self.cells[y][start:end] = drawn[y][start:end]
            return update

        def draw_all(compositor: Compositor, simplify: bool = False) -> Any:
            update = whole(compositor, simplify)
            self.cells = cells(compositor.render_strips())
            return update

        monkeypatch.setattr(Compositor, "render_partial_update", draw_part)
        monkeypatch.setattr(Compositor, "render_full_update", draw_all)

    def shows(self, it: Front) -> bool:
        """True when it shows what an app draws whose widgets have forgotten what they drew."""
        for widget in it.app.screen.walk_children(with_self=True):
            widget._styles_cache.clear()  # type: ignore[attr-defined]
        return self.cells == cells(it.strips)


async def test_the_first_picture_waits_for_the_robots_nodes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    on_mount: Any = main.MainScreen.on_mount
    monkeypatch.setattr(main.MainScreen, "on_mount", on_mount.__wrapped__)  # as it is for users
    monkeypatch.setattr(main, "_NODES_TIMEOUT", 3600.0)
    drawn: list[int] = []
    whole = Compositor.render_full_update

    def counted(compositor: Compositor, simplify: bool = False) -> Any:
        drawn.append(1)
        return whole(compositor, simplify)

    monkeypatch.setattr(Compositor, "render_full_update", counted)
    app = stub_app(STATES["normal"]._replace(nodes=()))
    async with app.run_test(size=(120, 36)) as pilot:
        await pilot.pause()  # It is never at rest before.
        assert drawn == []
        robot: Any = app.station.robot
        robot.put(STATES["normal"])
        await Quiet(app).settle()
        assert drawn[:1] == [1]


@pytest.mark.parametrize(
    ("size", "state"),
    corners(
        [((120, 36), "normal"), ((160, 48), "battery low and moving")],
        [
            (size, state)
            for size in (*SIZES, (200, 60))
            for state in ("normal", "battery low and moving", "motor stopped")
        ],
    ),
)
async def test_no_news_lay_the_screen_out_anew(size: tuple[int, int], state: str) -> None:
    """That draws all of it, and costs a slow line thousands of bytes."""
    clock, before, laid_out = StandingClock(), STATES[state], list[int]()
    async with front(before, clock, size=size) as it:
        it.main.screen_layout_refresh_signal.subscribe(it.app, lambda _: laid_out.append(1))
        for news in range(1, 6):
            clock.passed = news / 10
            battery = before.battery._replace(percentage=80.0 - news, received=clock.monotonic())
            goal = before.goal and before.goal._replace(remaining=9.0 - news)
            it.robot.put(before._replace(battery=battery, goal=goal))
            assert str(80 - news) in await it.tick()
    assert laid_out == []


@pytest.mark.parametrize(
    ("size", "steps"), corners([((80, 24), 20)], [(size, 80) for size in SIZES])
)
async def test_nothing_stays_of_where_the_focus_was(
    monkeypatch: pytest.MonkeyPatch, size: tuple[int, int], steps: int
) -> None:
    terminal, choose = Terminal(monkeypatch), random.Random(size[0])
    async with front(size=size) as it:
        for _ in range(steps):
            if choose.random() < 0.3:
                panel = choose.choice([p for p in it.app.screen.query(Panel) if p.region])
                width, height = panel.region.size
                x, y = choose.randrange(width), choose.choice((0, height // 2, height - 1))
                await it.click(panel.region.x + x, panel.region.y + y)
                what = f"a click on {panel.id} at {x}, {y}"
            else:
                await it.press(what := choose.choice(_KEYS))
            if it.app.screen is not it.main:  # a dialog, by a click on what has the cursor
                await it.press("escape")
            assert terminal.shows(it), what
    assert terminal.parts > steps // 3  # a key and what it changes are drawn at once


async def test_the_panel_with_the_focus_can_be_told_and_what_in_it() -> None:
    async with front() as it:

        async def after(key: str) -> dict[int, Cells]:
            await it.press(key)
            drawn, found = cells(it.strips), {}
            for panel in it.app.screen.query(Panel):
                region = panel.region
                lines = drawn[region.y : region.bottom]
                found[panel.number] = [c for line in lines for c in line[region.x : region.right]]
            return found

        parameters, motor = await after("4"), await after("2")
        assert "┏" in [char for char, _ in parameters[4]]
        assert "┏" not in [char for char, _ in parameters[2]]
        assert "┏" in [char for char, _ in motor[2]]
        assert "┏" not in [char for char, _ in motor[4]]
        assert any("reverse" in style for _, style in parameters[4])
        assert not any("reverse" in style for _, style in motor[4])
        drawn = motor
        for _ in range(10):
            before, drawn = drawn, await after("tab")
            assert drawn != before, it.app.focused


@pytest.mark.parametrize("size", corners(SIZES[:1], SIZES[1:]))
async def test_a_list_that_grows_shows_all_of_it_and_then_scrolls(
    monkeypatch: pytest.MonkeyPatch, size: tuple[int, int]
) -> None:
    terminal = Terminal(monkeypatch)
    events: tuple[Event, ...] = ()
    async with front(STATES["normal"]._replace(events=()), size=size) as it:
        rows = it.main.events.focus_target
        for number in range(2 * rows.size.height):
            event = Event(TIME + number, "WARN", "node", f"line {'x' * number}", number=number)
            events = (*events, event)
            shown = await it.put(it.robot.snapshot._replace(events=events))
            assert terminal.shows(it), number
            newest = min(number + 1, rows.size.height)
            assert all(f"line {'x' * n}" in shown for n in range(number - newest + 1, number + 1))
        assert rows.show_vertical_scrollbar
        assert "line  " in await it.write("6", "end")
        assert terminal.shows(it)


async def test_what_can_be_clicked_is_lit_below_the_mouse() -> None:
    async with console(*FAST) as op:
        footer = op.app.screen.query_one("#footer", Line)
        place = op.text.splitlines()[-1].index("r Reset") + 3
        (before,) = cells(footer.render_lines(footer.size.region))
        await op.pilot.hover("#footer", offset=(place, 0))
        await op.until(lambda: cells(footer.render_lines(footer.size.region)) != [before])
        (lit,) = cells(footer.render_lines(footer.size.region))
        assert lit[place][1] != before[place][1]


async def test_a_size_that_comes_while_the_machine_is_busy_is_followed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with front() as it:
        seconds = count()  # Between two looks at the time a second passes.
        monkeypatch.setattr("textual._time.get_time", lambda: float(next(seconds)))
        await it.resize(80, 24)
        await it.until(lambda: it.app.screen._compositor.size == (80, 24))


@pytest.mark.night
async def test_of_dialogs_that_were_closed_no_line_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    caches: WeakSet[StylesCache] = WeakSet()  # One for each widget whose lines were drawn.
    create, counts = StylesCache.__init__, list[int]()

    def create_and_count(cache: StylesCache) -> None:
        create(cache)
        caches.add(cache)

    monkeypatch.setattr(StylesCache, "__init__", create_and_count)
    async with front() as it:
        for _ in range(4):
            await it.press("ctrl+p", "escape", "A", "escape", "question_mark", "escape")
            gc.collect()
            counts.append(len(caches))
    assert 0 < counts[-1] <= counts[0] + 2, counts  # one more line may be drawn by now
