"""The app over a stub in a test: keys in, what the screen shows out; and its accepted pictures."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partialmethod
from pathlib import Path
from typing import Any, TypeVar

import pytest
from rich.console import Console
from textual.pilot import Pilot
from textual.strip import Strip

from archo_tui.base.clock import Clock
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.app import ArchoApp
from archo_tui.screen.main import MainScreen
from archo_tui.screen.widgets.rows import Rows
from tests.support.console import click, focused_panel, screen_text, send
from tests.support.quiet import Quiet
from tests.support.states import NORMAL
from tests.support.stub import stub_app


def reset_main(main: MainScreen) -> None:
    """Bring the main screen back to what it was at first; somebody has left the goal's field."""
    main.leave_full()
    for panel in (main.parameters, main.events):
        panel.search.close()
    while main.events._level != "WARN":
        main.events.next_level()
    if main.parameters._only_changed:
        main.parameters.toggle_changed()
    if main.parameters._shows_all:
        main.parameters.toggle_hidden()
    for rows in main.query(Rows).results():
        rows.cursor, rows.shows_cursor = 0, False
    main.goal.fields[0].clear()
    main.goal.typed, main.goal._typed_index = [], 0
    main.focus_panel(4)
    main.parameters.rows.shows_cursor = False
    main._focused_before = None
    main.app.clear_notifications()


class Front:
    """An operator in front of the app."""

    def __init__(self, app: ArchoApp, pilot: Pilot[None]) -> None:
        self.app, self.main = app, app.main
        self.robot: Any = app.station.robot
        self._pilot, self._quiet = pilot, Quiet(app)

    async def settle(self) -> str:
        """Let everything be done that is to be done; returns what the screen shows then."""
        await self._quiet.settle()
        return self.text

    async def until(self, holds: Callable[[], object]) -> None:
        """Wait until it holds."""
        await self._quiet.until(holds, lambda: self.text)

    async def press(self, *keys: str) -> str:
        """Press keys one after the other."""
        for key in keys:
            await self.write(key)
        return self.text

    async def write(self, *keys: str) -> str:
        """Press keys all at once, as they come over a slow link."""
        send(self.app, *keys)
        return await self.settle()

    async def click(self, x: int, y: int) -> str:
        click(self.app, x, y)
        return await self.settle()

    async def put(self, snapshot: Snapshot) -> str:
        """Something new was heard."""
        self.robot.put(snapshot)
        return await self.settle()

    async def tick(self) -> str:
        """A second has passed."""
        self.app.tick()
        return await self.settle()

    async def resize(self, width: int, height: int) -> str:
        await self._pilot.resize_terminal(width, height)
        return await self.settle()

    @property
    def text(self) -> str:
        """What the screen shows, line by line; nothing when it has ended."""
        return screen_text(self.app) if self.app.is_running else ""

    @property
    def strips(self) -> list[Strip]:
        """The lines of the screen as they are drawn."""
        return self.app.screen._compositor.render_strips()

    @property
    def focused_panel(self) -> int:
        """The number of the panel that has the focus; 0 for none."""
        return focused_panel(self.app)


F = TypeVar("F", bound=Front)


@asynccontextmanager
async def front_of(
    kind: Callable[[ArchoApp, Pilot[None]], F],
    snapshot: Snapshot = NORMAL,
    clock: Clock | None = None,
    size: tuple[int, int] = (120, 36),
    **options: Any,
) -> AsyncIterator[F]:
    """The app in a terminal of that size, at rest; the rest is as of `stub_app`."""
    app = stub_app(snapshot, clock, size=size, **options)
    async with app.run_test(size=size) as pilot:
        operator = kind(app, pilot)
        await operator.settle()
        yield operator


def front(*given: Any, **options: Any) -> AbstractAsyncContextManager[Front]:
    return front_of(Front, *given, **options)


FOLDER = Path(__file__).parent.parent / "snapshots"


def steady(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing of this machine is in a picture."""
    monkeypatch.chdir("/")  # a dialog names the folder
    monkeypatch.setenv("COLORTERM", "truecolor")
    # else the ids in a picture are made of all that is in it
    export_svg = partialmethod(Console.export_svg, unique_id="terminal")
    monkeypatch.setattr(Console, "export_svg", export_svg)


def differs(request: pytest.FixtureRequest, name: str, actual: str) -> list[str]:
    """What to say when the picture differs from the accepted one; the new one is left beside it."""
    path = FOLDER / f"{name.replace(' ', '_')}.svg"
    new = path.with_suffix(".new.svg")
    if request.config.getoption("--update-snapshots"):
        path.write_text(actual)
    if path.is_file() and path.read_text() == actual:
        new.unlink(missing_ok=True)
        return []
    new.write_text(actual)
    return [f"{path.name} differs: look at {new}, accept it with --update-snapshots"]
