"""A restart of the console, which waits while a STOP is not released."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from archo_tui.app import ArchoApp
from archo_tui.robot.state import Latch, OpenStop, Snapshot
from archo_tui.shutdown import RESTART
from tests.support.console import screen_text, send
from tests.support.quiet import Quiet
from tests.support.states import MOTOR, NORMAL
from tests.support.stub import StubRobot, stub_app

HELD = NORMAL._replace(latch=Latch.HELD, motion=replace(MOTOR, stopped=True))
UNCERTAIN = NORMAL._replace(latch=Latch.UNCERTAIN)
OPEN = NORMAL._replace(open_stop=OpenStop(0.0))


class Saved:
    """A console with a file that is saved, and the codes with which it begins to end."""

    def __init__(self, app: ArchoApp) -> None:
        self.app, self.quiet, self.codes = app, Quiet(app), list[int]()
        app.exit = lambda *_, return_code=0, **__: self.codes.append(return_code)  # type: ignore[method-assign]
        self.robot: StubRobot = app.station.robot  # type: ignore[assignment]
        self.events: list[str] = []
        self.robot.note = lambda _, __, text, **___: self.events.append(text)  # type: ignore[attr-defined]

    async def save(self) -> None:
        self.app.station.restart("interfaces were saved")
        await self.quiet.settle()

    async def press(self, *keys: str) -> str:
        send(self.app, *keys)
        await self.quiet.settle()
        return screen_text(self.app)


@pytest.mark.parametrize("stopped", [HELD, UNCERTAIN, OPEN], ids=["held", "uncertain", "open"])
async def test_a_restart_waits_for_the_release_and_then_for_a_key(stopped: Snapshot) -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(120, 36)):
        it = Saved(app)
        it.robot.put(stopped)
        await it.save()
        assert it.codes == []
        waits = "the restart waits: release the STOP, then press ^r in Nodes"
        assert it.events == [f"interfaces were saved: {waits}"]
        assert "5 Nodes   restart waits" in await it.press("5")
        assert "release" in await it.press("ctrl+r")  # Why not now.
        assert it.codes == []
        it.robot.put(NORMAL)
        await it.quiet.settle()
        assert it.codes == []  # The release itself begins nothing.
        await it.press("ctrl+r")
        assert it.codes == [RESTART]
        assert it.events[-1] == "interfaces were saved: all nodes restart"


async def test_a_stop_that_was_read_and_has_no_answer_keeps_the_console_too() -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(120, 36)):
        it = Saved(app)
        it.robot.stops.register()
        await it.save()
        assert it.codes == []
        assert "the restart waits" in it.events[-1]


async def test_a_stop_while_the_console_begins_to_end_calls_the_restart_off() -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(120, 36)):
        it = Saved(app)
        allowed: list[bool] = []

        async def stop_sending_goals() -> None:
            it.robot.snapshot = HELD  # Read, sent and confirmed in this moment.

        def allow_sending_goals() -> None:
            allowed.append(True)

        robot: Any = it.robot
        robot.stop_sending_goals, robot.allow_sending_goals = (
            stop_sending_goals,
            allow_sending_goals,
        )
        await it.save()
        assert it.codes == []
        assert allowed == [True]
        assert "the restart waits" in it.events[-1]
        it.robot.put(NORMAL)
        await it.press("5", "ctrl+r")  # And begins again, though it was begun before.
        assert it.codes == []  # Another STOP came.


async def test_without_a_stop_a_saved_file_restarts_at_once() -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(120, 36)):
        it = Saved(app)
        assert "restart" not in await it.press("5")
        await it.press("ctrl+r")
        assert it.codes == []  # Nothing waits.
        await it.save()
        assert it.codes == [RESTART]
        assert "? the console restarts" in screen_text(app)  # Not `online`.
