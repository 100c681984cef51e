"""Keys beside an answer that is waited for, and beside a question that is asked."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screen.keyed_app import HELD
from tests.support.console import key_event, screen_text, send
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import stub_app


@pytest.mark.parametrize("key", ["ctrl+c", "escape"])
async def test_a_key_that_waits_for_no_answer_does_not_wait_behind_keys_that_do(key: str) -> None:
    app, cancelled = stub_app(STATES["motor moving"]), []
    answer = asyncio.Event()

    async def unanswered(*_: Any, **__: Any) -> Outcome:
        await answer.wait()
        return Outcome(Code.DONE, "done")

    async def cancel(**_: Any) -> Outcome:
        cancelled.append(answer.is_set())
        return Outcome(Code.ACCEPTED, "accepted")

    robot: Any = app.station.robot
    robot.set_parameters, robot.cancel = unanswered, cancel
    async with app.run_test(size=(120, 36)):
        settle = Quiet(app).settle
        await settle()
        send(app, "4", "enter", "ctrl+u", "2", "enter", "x", "q")
        await settle()
        dialog, late = app.screen, key_event(key)
        assert dialog is not app.main
        late.time += HELD
        app.post_message(late)
        await settle()
        assert "dropped" in screen_text(app)
        if key == "escape":
            assert app.screen is app.main
        else:
            assert cancelled == [False]
        answer.set()
        await settle()
        assert app.screen is app.main  # where neither x nor q came, which would have asked


async def test_a_second_question_is_not_put_and_that_is_said() -> None:
    app = stub_app(STATES["motor moving"])
    async with app.run_test(size=(120, 36)):
        settle = Quiet(app).settle
        await settle()
        for key in ("r", "ctrl+q"):
            send(app, key)
            await settle()
        assert "Reset encoder now?" in screen_text(app)
        assert "answer the question that is asked" in screen_text(app)
