"""The first picture is drawn once, and news lay nothing out anew."""

from __future__ import annotations

from typing import Any

import pytest
from textual._compositor import Compositor
from textual.screen import Screen

from archo_tui.screen import main
from tests.support.console import screen_text
from tests.support.night import corners
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import StandingClock, StubRobot, stub_app

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
    whole = Compositor.render_full_update

    def counted(compositor: Compositor, simplify: bool = False) -> Any:
        drawn.append(len(robot.snapshot.nodes))
        return whole(compositor, simplify)

    monkeypatch.setattr(Compositor, "render_full_update", counted)
    app = stub_app(STATES["normal"]._replace(nodes=()))
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    async with app.run_test(size=(120, 36)) as pilot:
        await pilot.pause()
        assert drawn == []
        robot.put(STATES["normal"])
        await Quiet(app).settle()
    assert drawn[:1] == [len(STATES["normal"].nodes)]


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
