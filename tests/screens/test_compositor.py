"""Only what changed is drawn, and what is drawn is what Textual itself would draw."""

from __future__ import annotations

import random
import re
from typing import Any

import pytest
from textual._compositor import ChopsUpdate, Compositor
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Button

from archo_tui.screens import main
from archo_tui.terminal.compositor import DirtyCompositor
from tests.support.console import screen_text, send
from tests.support.night import corners
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import StandingClock, StubRobot, stub_app

# Textual moves the cursor to the end of a span, too, when another widget begins there
_EMPTY_MOVE = re.compile(r"\x1b\[\d+;\d+H(?=\x1b\[\d+;\d+H|\n|$)")
_DRAW = Screen._compositor_refresh
_KEYS = [*"12345678", "down", "up", "end", "slash", "a", "h", "e", "escape", "l", "enter", "?"]


@pytest.fixture(autouse=True)
def _drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here it counts what is drawn."""
    monkeypatch.setattr(Screen, "_compositor_refresh", _DRAW)


async def test_the_first_picture_waits_for_the_robots_nodes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    on_mount: Any = main.MainScreen.on_mount
    monkeypatch.setattr(main.MainScreen, "on_mount", on_mount.__wrapped__)  # as it is for users
    monkeypatch.setattr(main, "_NODES_TIMEOUT", 3600.0)
    drawn: list[int] = []
    whole = DirtyCompositor.render_full_update

    def counted(compositor: DirtyCompositor, simplify: bool = False) -> Any:
        drawn.append(len(robot.snapshot.nodes))
        return whole(compositor, simplify)

    monkeypatch.setattr(DirtyCompositor, "render_full_update", counted)
    app = stub_app(STATES["normal"]._replace(nodes=()))
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    async with app.run_test(size=(120, 36)) as pilot:
        await pilot.pause()
        assert drawn == []
        robot.put(STATES["normal"])
        await Quiet(app).settle()
    assert drawn[:1] == [len(STATES["normal"].nodes)]


@pytest.mark.parametrize(
    ("size", "steps"),
    corners(
        [((160, 48), 25)],
        [(size, 100) for size in ((40, 10), (80, 24), (120, 36), (160, 48))],
    ),
)
async def test_a_part_of_the_screen_is_drawn_as_textual_draws_it(
    monkeypatch: pytest.MonkeyPatch, size: tuple[int, int], steps: int
) -> None:
    drawn: list[str] = []
    part = DirtyCompositor.render_partial_update

    def compared(compositor: DirtyCompositor) -> ChopsUpdate | None:
        dirty = compositor._dirty_regions.copy()
        update = part(compositor)
        compositor._dirty_regions = dirty
        with monkeypatch.context() as patch:
            patch.setattr(DirtyCompositor, "_get_renders", Compositor._get_renders)
            expected = Compositor.render_partial_update(compositor)
        if update is not None and expected is not None:
            console = compositor.root.app.console  # type: ignore[union-attr]
            drawn.append(_EMPTY_MOVE.sub("", update.render_segments(console)))
            assert drawn[-1] == _EMPTY_MOVE.sub("", expected.render_segments(console))
        return update

    monkeypatch.setattr(DirtyCompositor, "render_partial_update", compared)
    app = stub_app(STATES["normal"], size=size)
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    choose = random.Random(1)
    states: list[Any] = sorted(set(STATES) - {"many parameters"})
    async with app.run_test(size=size):
        quiet = Quiet(app)
        await quiet.settle()
        for _ in range(steps):
            robot.put(STATES[choose.choice(states)])
            send(app, choose.choice(_KEYS))
            await quiet.settle()
    assert len(drawn) > steps // 3


async def test_only_what_changed_is_asked_for_its_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    lines = Button.render_lines

    def counted(button: Button, crop: Any) -> Any:
        asked.append(button)
        return lines(button, crop)

    app = stub_app(STATES["normal"])
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        monkeypatch.setattr(Button, "render_lines", counted)
        app.main.query_one("#clock").refresh()
        await quiet.settle()
        assert asked == []
        app.main.query_one("#reset", Button).refresh()
        await quiet.settle()
        assert {button.id for button in asked} == {"reset"}


async def test_of_a_dialog_too_only_what_changed_is_asked_for_its_lines(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[str | None] = []
    lines = Widget.render_lines

    def counted(widget: Widget, crop: Any) -> Any:
        asked.append(widget.id)
        return lines(widget, crop)

    app = stub_app(STATES["normal"])
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        send(app, "8", "home", "down", "enter")
        await quiet.settle()
        monkeypatch.setattr(Widget, "render_lines", counted)
        app.screen.query_one(".summary").refresh()  # Above the fields.
        app.screen.query_one("#topic-ends-text").refresh()  # Below them.
        await quiet.settle()
        assert set(asked) == {"topic-ends-text"}  # A line has a way of its own.


@pytest.mark.parametrize(
    ("size", "state"),
    corners(
        [((120, 36), "normal"), ((160, 48), "battery low and moving")],
        [
            (size, state)
            for size in ((80, 24), (120, 36), (160, 48), (200, 60))
            for state in ("normal", "battery low and moving", "motor stopped")
        ],
    ),
)
async def test_no_news_lay_the_screen_out_anew(size: tuple[int, int], state: str) -> None:
    """That draws all of it, and costs a slow line thousands of bytes."""
    clock, before, laid_out = StandingClock(), STATES[state], 0

    def count(_: Screen[Any]) -> None:
        nonlocal laid_out
        laid_out += 1

    app = stub_app(before, clock, size=size)
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    async with app.run_test(size=size):
        quiet = Quiet(app)
        await quiet.settle()
        app.main.screen_layout_refresh_signal.subscribe(app, count)
        for news in range(1, 6):
            clock.passed = news / 10
            battery = before.battery._replace(percentage=80.0 - news, received=clock.monotonic())
            goal = before.goal and before.goal._replace(remaining=9.0 - news)
            robot.put(before._replace(battery=battery, goal=goal))
            app.tick()
            await quiet.settle()
            assert str(80 - news) in screen_text(app)
    assert laid_out == 0
