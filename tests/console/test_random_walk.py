"""Thousands of keys at random, over all screens: nothing breaks, nothing sticks, STOP answers."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from textual.widgets import Input

from archo_tui.commands import registry
from archo_tui.robot.state import Outcome
from tests.console.states import STATES
from tests.support.archo import ARCHO
from tests.support.console import send
from tests.support.quiet import Quiet
from tests.support.stub import StubRobot, stub_app

COMMANDS = registry(ARCHO)
_KEYS = sorted(
    {command.key for command in COMMANDS if command.key}
    | set("0123456789azAZ .-") | {"tab", "shift+tab", "escape", "enter", "up", "down", "left"}
    | {"right", "pageup", "pagedown", "home", "end", "backspace", "delete", "ctrl+home", "ctrl+end"}
)  # fmt: skip
_LEAVING = {"ctrl+q", "q", "ctrl+z", "ctrl+p"}  # end the walk, or read the themes' files
_EACH = 100  # keys between two looks at the invariants


async def walk(seed: int, keys: int) -> None:
    """Press keys at random; the state of the robot changes at random as well."""
    choose = random.Random(seed)
    names = sorted(set(STATES) - {"many parameters"})
    app = stub_app(STATES["normal"])
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    stops: list[int] = []

    async def stop() -> Outcome:
        stops.append(1)
        return Outcome(True, "stopped")

    robot.emergency_stop = stop  # type: ignore[attr-defined]
    possible = [key for key in _KEYS if key not in _LEAVING and key != "ctrl+x"]
    async with app.run_test(size=(100, 30)):
        quiet = Quiet(app)

        async def press(*pressed: str) -> None:
            send(app, *pressed)
            await quiet.settle()

        for number in range(keys // _EACH):
            robot.put(STATES[choose.choice(names)])
            pressed = [choose.choice(possible) for _ in range(_EACH)]
            await press(*pressed)
            app.clear_notifications()
            where = f"seed {seed}, after {number * _EACH + _EACH} keys, the last: {pressed[-20:]}"
            robot.put(STATES["normal"])
            stops.clear()
            await press("ctrl+x")
            assert stops == [1], where
            assert app.is_running, where
            for _ in range(10):  # no dialog sticks
                if app.screen is app.main:
                    break
                await press("escape")
            assert app.screen is app.main, where
            if isinstance(app.focused, Input):
                await press("escape")
            assert app.focused is not None, where
            assert not isinstance(app.focused, Input), where


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files may be saved on the way."""
    monkeypatch.chdir(tmp_path)


async def test_a_walk_of_keys_at_random(request: pytest.FixtureRequest) -> None:
    far = request.config.getoption("--end-to-end")
    await walk(seed=random.randrange(10**6) if far else 7, keys=20_000 if far else 600)
