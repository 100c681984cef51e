"""Quitting and suspending with a goal running: what is asked, and what becomes of the goal."""

from __future__ import annotations

import asyncio
import signal
from types import SimpleNamespace
from typing import Any

import pytest

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screen.app import ArchoApp
from tests.support.console import screen_text, send
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import stub_app


class Asked:
    """An app whose robot is on its way, and what it was asked to do."""

    def __init__(self, **options: Any) -> None:
        self.app: ArchoApp = stub_app(STATES["motor moving"], **options)
        self.cancelled = False
        self.said: list[str] = []
        robot: Any = self.app.station.robot
        robot.cancel = self._cancel
        robot.note = lambda level, source, text, command="": self.said.append(text)

    async def _cancel(self) -> Outcome:
        self.cancelled = True
        return Outcome(Code.REFUSED, "refused")

    async def press(self, *keys: str) -> str:
        """Press keys; returns what the screen shows then."""
        for key in keys:
            send(self.app, key)
            await Quiet(self.app).settle()
        return screen_text(self.app) if self.app.is_running else ""


async def test_leaving_it_running_does_not_cancel() -> None:
    it = Asked(attached=True)
    async with it.app.run_test(size=(120, 36)):
        assert "Leave it running and quit" in await it.press("q")
        await it.press("tab", "tab", "enter")
        assert not it.app.is_running
    assert not it.cancelled
    assert it.said == ["quit: the goal to shelf 12 is left running"]


@pytest.mark.parametrize(
    ("state", "said"),
    [
        ("motor stopped", "the STOP holds on until R in a console"),
        ("motor stop not confirmed", "once this console has ended nobody repeats it"),
    ],
)
async def test_quitting_while_stopped_says_what_becomes_of_the_stop(state: str, said: str) -> None:
    it = Asked(attached=True)
    robot: Any = it.app.station.robot
    robot.snapshot = STATES[state]._replace(goal=None)
    async with it.app.run_test(size=(120, 36)):
        shown = await it.press("q")
        assert said in " ".join(shown.replace("┃", " ").split())
        await it.press("escape", "q", "tab", "enter")
        assert not it.app.is_running


@pytest.mark.parametrize("state", ["normal", "motor moving"])
async def test_quitting_says_that_what_is_published_ends(state: str) -> None:
    it = Asked()
    robot: Any = it.app.station.robot
    robot.snapshot = STATES[state]
    published = SimpleNamespace(text="pub /words, at 10 Hz")
    robot.publications = SimpleNamespace(active=(published,))
    async with it.app.run_test(size=(120, 36)):
        shown = " ".join((await it.press("q")).replace("┃", " ").split())
        assert "pub /words, at 10 Hz, ends with this console." in shown
        await it.press("escape")
        assert it.app.is_running


async def test_suspending_and_quitting_ask_one_thing_at_a_time() -> None:
    it = Asked()
    async with it.app.run_test(size=(120, 36)):
        said = await it.press("ctrl+z")
        assert "The robot is on its way to shelf 12; its nodes would pause." in said
        assert "Suspend" not in (await it.press("enter"))
        assert it.app.screen is it.app.main

        await it.press("escape")
        await it.press("q")
        assert "Cancel goal and quit" in await it.press("ctrl+z")
        assert len(it.app.screen_stack) == 2

        await it.press("escape")
        assert "Leave it running" not in await it.press("q")
        await it.press("tab", "enter")
        assert not it.app.is_running
    assert it.cancelled


async def test_an_answer_is_chosen_by_arrows_or_by_its_first_letter() -> None:
    for keys in (["right", "enter"], ["c"], ["right", "right", "left", "enter"]):
        it = Asked(attached=True)
        async with it.app.run_test(size=(120, 36)):
            assert "first letter" in await it.press("q")
            await it.press(*keys)
            assert not it.app.is_running
        assert it.cancelled, keys
    it = Asked(attached=True)
    async with it.app.run_test(size=(120, 36)):
        await it.press("q", "y")  # which of the two that act?
        assert len(it.app.screen_stack) == 2
        await it.press("s")
        assert it.app.screen is it.app.main


async def test_a_goal_that_left_just_before_quitting_is_cancelled() -> None:
    it = Asked()
    robot: Any = it.app.station.robot
    moving, robot.snapshot = robot.snapshot, STATES["normal"]

    async def stop_sending_goals() -> None:
        robot.snapshot = moving  # it is heard of only now

    robot.stop_sending_goals = stop_sending_goals
    async with it.app.run_test(size=(120, 36)):
        await it.press("q")
        assert not it.app.is_running
    assert it.cancelled
    assert it.said == ["quit: cancelling the goal to shelf 12"]


@pytest.mark.parametrize("end", ["ctrl+q", "SIGTERM", "SIGHUP"])
async def test_the_end_waits_for_the_answer_to_a_stop(end: str) -> None:
    app = stub_app(STATES["normal"])
    answer = asyncio.get_running_loop().create_future()
    robot: Any = app.station.robot
    robot.emergency_stop = lambda: answer
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        if end == "ctrl+q":
            send(app, "ctrl+x", "ctrl+q")  # at once
        else:
            send(app, "ctrl+x")
            await quiet.settle()
            app._ending.begin(128 + signal.Signals[end])
        await quiet.settle()
        assert app.is_running
        answer.set_result(Outcome(Code.DONE, "stopped"))
        await quiet.settle()
        assert not app.is_running
