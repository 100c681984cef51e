"""Thousands of keys, clicks, pastes and sizes of the terminal at random, over all screens.

Nothing breaks, nothing sticks, STOP answers.
"""

from __future__ import annotations

import asyncio
import random
from pathlib import Path
from typing import Any

import pytest
from textual import events
from textual.app import App
from textual.geometry import Size
from textual.widgets import Input

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screen.commands import registry
from tests.support.archo import ARCHO
from tests.support.console import click, send
from tests.support.front import front
from tests.support.states import STATES

COMMANDS = registry(ARCHO)
_KEYS = sorted(
    {command.key for command in COMMANDS if command.key}
    | set("0123456789azAZ .-") | {"tab", "shift+tab", "escape", "enter", "up", "down", "left"}
    | {"right", "pageup", "pagedown", "home", "end", "backspace", "delete", "ctrl+home", "ctrl+end"}
)  # fmt: skip
_LEAVING = {"ctrl+q", "q", "ctrl+z"}  # end the walk
_EACH = 50  # keys between two looks at the invariants
_PASTES = ("12", "a\nb", "\x1b[31m", "9" * 300, "x: [", "  7 ")
_SIZES = ((80, 24), (120, 36), (160, 48), (79, 23), (200, 60), (40, 10), (20, 5), (1, 1))
_SIZE = Size(100, 30)


def something_else(app: App[Any], choose: random.Random) -> None:
    """A click, a paste or another size of the terminal."""
    what = choose.randrange(4)
    if what == 0:
        app.post_message(events.Paste(choose.choice(_PASTES)))
    elif what == 1:
        size = Size(*choose.choice(_SIZES))
        app.post_message(events.Resize(size, size))
    else:
        click(app, choose.randrange(app.size.width), choose.randrange(app.size.height))


async def walk(seed: int, keys: int) -> None:
    """Press keys at random; the state of the robot changes at random as well."""
    choose = random.Random(seed)
    names = sorted(set(STATES) - {"many parameters"})
    stops: list[int] = []

    async def stop() -> Outcome:
        stops.append(1)
        return Outcome(Code.DONE, "stopped")

    possible = [key for key in _KEYS if key not in _LEAVING and key != "ctrl+x"]
    async with front(size=(_SIZE.width, _SIZE.height)) as it:
        app, robot, press = it.app, it.robot, it.press
        robot.emergency_stop = stop
        app.exit = lambda *_, **__: None  # type: ignore[method-assign]  # by a click, or the palette
        app.action_suspend_process = lambda: None  # type: ignore[method-assign]
        for number in range(keys // _EACH):
            robot.put(STATES[choose.choice(names)])
            pressed = [choose.choice(possible) for _ in range(_EACH)]
            for key in pressed:
                send(app, key)
                if choose.random() < 0.1:
                    something_else(app, choose)
                    await asyncio.sleep(0)  # it comes while what was before is being done
            await it.settle()
            app.clear_notifications()
            app.post_message(events.Resize(_SIZE, _SIZE))
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


async def test_a_walk_of_keys_at_random() -> None:
    await walk(seed=7, keys=100)


@pytest.mark.night
@pytest.mark.parametrize("_part", range(10))
async def test_a_long_walk_of_keys_at_random(_part: int) -> None:
    await walk(seed=random.randrange(10**6), keys=2000)
