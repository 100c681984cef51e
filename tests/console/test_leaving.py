"""Questions before quitting and suspending, and keys beside a question or an unanswered request."""

from __future__ import annotations

import asyncio
import signal
from types import SimpleNamespace
from typing import Any

import pytest

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screen.keyed_app import HELD
from tests.support.console import key_event
from tests.support.front import Front, front
from tests.support.states import NORMAL, STATES

MOVING = STATES["motor moving"]


def noted(it: Front) -> list[str]:
    """What is noted from now on, and each cancel."""
    found: list[str] = []

    async def cancel(**_: Any) -> Outcome:
        found.append("cancelled")
        return Outcome(Code.REFUSED, "refused")

    it.robot.cancel = cancel
    it.robot.note = lambda level, source, text, command="": found.append(text)
    return found


def one_line(shown: str) -> str:
    return " ".join(shown.replace("┃", " ").split())


async def test_leaving_it_running_does_not_cancel() -> None:
    async with front(MOVING, attached=True) as it:
        said = noted(it)
        assert "Leave it running and quit" in await it.press("q")
        await it.press("y")  # Which of the two that act?
        assert len(it.app.screen_stack) == 2
        await it.press("s")
        assert it.app.screen is it.main
        await it.press("q", "tab", "tab", "enter")
        assert not it.app.is_running
    assert said == ["quit: the goal to shelf 12 is left running"]


@pytest.mark.parametrize(
    ("state", "said"),
    [
        ("motor stopped", "the STOP holds on until R in a console"),
        ("motor stop not confirmed", "once this console has ended nobody repeats it"),
    ],
)
async def test_quitting_while_stopped_says_what_becomes_of_the_stop(state: str, said: str) -> None:
    async with front(STATES[state]._replace(goal=None), attached=True) as it:
        assert said in one_line(await it.press("q"))
        await it.press("escape", "q", "tab", "enter")
        assert not it.app.is_running


async def test_quitting_says_that_what_is_published_ends() -> None:
    async with front() as it:
        published = SimpleNamespace(text="pub /words, at 10 Hz")
        it.robot.publications = SimpleNamespace(active=(published,))
        for state in ("normal", "motor moving"):
            await it.put(STATES[state])
            shown = one_line(await it.press("q"))
            assert "pub /words, at 10 Hz, ends with this console." in shown
            await it.press("escape")
            assert it.app.is_running


async def test_suspending_and_quitting_ask_one_thing_at_a_time() -> None:
    async with front(MOVING) as it:
        said = noted(it)
        for key in ("r", "ctrl+q"):
            await it.press(key)
        assert "Reset encoder now?" in it.text
        assert "answer the question that is asked" in it.text
        await it.press("escape")

        assert "on its way to shelf 12; its nodes would pause." in await it.press("ctrl+z")
        assert "Suspend" not in await it.press("enter")
        assert it.app.screen is it.main

        await it.press("escape", "q")
        assert "Cancel goal and quit" in await it.press("ctrl+z")
        assert len(it.app.screen_stack) == 2

        await it.press("escape")
        assert "Leave it running" not in await it.press("q")
        await it.press("tab", "enter")
        assert not it.app.is_running
    assert "cancelled" in said


async def test_an_answer_is_chosen_by_arrows_or_by_its_first_letter() -> None:
    for keys in (["right", "enter"], ["c"], ["right", "right", "left", "enter"]):
        async with front(MOVING, attached=True) as it:
            said = noted(it)
            assert "first letter" in await it.press("q")
            await it.press(*keys)
            assert not it.app.is_running
        assert "cancelled" in said, keys


async def test_a_goal_that_left_just_before_quitting_is_cancelled() -> None:
    async with front(NORMAL) as it:
        said = noted(it)

        async def stop_sending_goals() -> None:
            it.robot.snapshot = MOVING  # it is heard of only now

        it.robot.stop_sending_goals = stop_sending_goals
        await it.press("q")
        assert not it.app.is_running
    assert said == ["quit: cancelling the goal to shelf 12", "cancelled"]


@pytest.mark.parametrize("end", ["ctrl+q", "SIGTERM"])
async def test_the_end_waits_for_the_answer_to_a_stop(end: str) -> None:
    async with front(NORMAL) as it:
        answer = asyncio.get_running_loop().create_future()
        it.robot.emergency_stop = lambda: answer
        if end == "ctrl+q":
            await it.write("ctrl+x", "ctrl+q")
        else:
            await it.press("ctrl+x")
            it.app._ending.begin(128 + signal.Signals[end])
            await it.settle()
        assert it.app.is_running
        answer.set_result(Outcome(Code.DONE, "stopped"))
        await it.settle()
        assert not it.app.is_running


@pytest.mark.parametrize("key", ["ctrl+c", "escape"])
async def test_a_key_that_waits_for_no_answer_does_not_wait_behind_keys_that_do(key: str) -> None:
    answer, cancelled = asyncio.Event(), list[bool]()

    async def unanswered(*_: Any, **__: Any) -> Outcome:
        await answer.wait()
        return Outcome(Code.DONE, "done")

    async def cancel(**_: Any) -> Outcome:
        cancelled.append(answer.is_set())
        return Outcome(Code.ACCEPTED, "accepted")

    async with front(MOVING) as it:
        it.robot.set_parameters, it.robot.cancel = unanswered, cancel
        await it.write("4", "enter", "ctrl+u", "2", "enter", "x", "q")
        dialog, late = it.app.screen, key_event(key)
        assert dialog is not it.main
        late.time += HELD
        it.app.post_message(late)
        assert "dropped" in await it.settle()
        if key == "escape":
            assert it.app.screen is it.main
        else:
            assert cancelled == [False]
        answer.set()
        await it.settle()
        assert it.app.screen is it.main  # where neither x nor q came, which would have asked
