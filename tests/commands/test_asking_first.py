"""A question in a form: the second `enter` is the answer, for what was asked about."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from archo_tui.commands.base import asking_first
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.verbs.verb import Question


async def test_an_answer_is_for_the_values_that_were_asked_about_and_not_for_others() -> None:
    now, sent = [0.0], list[Any]()
    station = SimpleNamespace(clock=SimpleNamespace(monotonic=lambda: now[0]))
    console: Any = SimpleNamespace(station=station)

    async def send(values: Any) -> Outcome:
        sent.append(values)
        return Outcome(Code.DONE, "")

    ask_or_send = asking_first(console, lambda _: Question("", "Sure?", "No", "Yes"), send)
    for now[0], values in ((0.0, {"x": 1}), (1.0, {"x": 5}), (1.1, {"x": 5})):
        assert (await ask_or_send(values)).text == "Sure? Then send it again."
    now[0] = 2.0
    assert (await ask_or_send({"x": 5})).ok
    assert sent == [{"x": 5}]
