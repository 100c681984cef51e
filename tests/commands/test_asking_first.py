"""A question and its answer, which is for what was asked about."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.screen.commands.base import asking_first
from archo_tui.verbs.verb import GOAL_ENDED, Question
from tests.support.front import front
from tests.support.states import NORMAL, goal


async def test_an_answer_is_for_the_values_and_the_goal_that_were_asked_about() -> None:
    now, sent = [0.0], list[Any]()
    station = SimpleNamespace(clock=SimpleNamespace(monotonic=lambda: now[0]), running_goal=None)
    console: Any = SimpleNamespace(station=station)

    async def send(values: Any) -> Outcome:
        sent.append(values)
        return Outcome(Code.DONE, "")

    station.running_goal = goal(Phase.MOVING).running_goal

    def ask(_: Any) -> Question:
        return Question("", "Sure?", "No", "Yes", station.running_goal)

    ask_or_send = asking_first(console, ask, send)
    for now[0], values in ((0.0, {"x": 1}), (1.0, {"x": 5}), (1.1, {"x": 5})):
        assert (await ask_or_send(values)).text == "Sure? Then send it again."
    now[0], station.running_goal = 2.0, None  # It has ended since.
    assert not (await ask_or_send({"x": 5})).ok
    now[0] = 3.0
    assert (await ask_or_send({"x": 5})).ok
    assert sent == [{"x": 5}]


async def test_a_yes_about_a_goal_that_has_just_ended_is_none() -> None:
    told: list[str] = []
    async with front(goal(Phase.MOVING)) as it:
        it.robot.command = lambda *_: told.append("reset")
        assert "Reset encoder now?" in await it.press("escape", "r")
        it.robot.snapshot = NORMAL  # Nothing was drawn since.
        assert f"Reset encoder: {GOAL_ENDED}" in await it.press("y")
        assert told == []
