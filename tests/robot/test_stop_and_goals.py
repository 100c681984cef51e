"""A goal that was typed before a STOP, wherever it is by then."""

from __future__ import annotations

import asyncio
from typing import Any

from rclpy.task import Future

from archo_tui.robot.outcome import Code
from archo_tui.robot.stop.gate import NOT_SENT
from tests.support.archo import SHELF, go
from tests.support.by_hand import ByHand
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.ros import begin


class Slow(ByHand):
    """Takes a goal only when it is told to."""

    def __init__(self, **options: Any) -> None:
        super().__init__("slow", **options)
        self.takes: Future[bool] = Future()

    async def accept(self, request: Any, response: Any) -> Any:
        await super().accept(request, response)
        await self.takes
        return response


async def test_a_goal_that_is_accepted_after_a_stop_is_cancelled_at_once() -> None:
    made: list[Slow] = []
    async with robot(making(made, Slow), offers="move_to_shelf") as it:
        task = asyncio.ensure_future(go(it, 3))
        await until(lambda: made[0].goal_ids)
        it.stops.register()
        stop = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: it.snapshot.open_stop is not None)
        begin(made[0], lambda: made[0].takes.set_result(True))
        await until(task.done)
        assert task.result() == (Code.CANCELLED, "accepted after a STOP: cancelling it")
        await until(lambda: made[0].cancelled)
        said = "shelf 3 was accepted after a STOP: cancelling it"
        await until(lambda: said in [event.text for event in it.snapshot.events])
        assert not (await ended(stop)).ok
        assert it.snapshot.open_stop is not None  # A goal from before it does not confirm it.


async def test_a_goal_that_moves_though_a_stop_came_before_its_answer_is_cancelled() -> None:
    made: list[Slow] = []
    async with robot(making(made, Slow), offers="move_to_shelf") as it:
        task = asyncio.ensure_future(go(it, 3))
        await until(lambda: made[0].goal_ids)
        it.stops.register()
        assert (await ended(task)).code is Code.TIMEOUT
        begin(made[0], made[0].feed, made[0].goal_ids[0], 9.0)
        await until(lambda: made[0].cancelled)


async def test_a_goal_typed_before_a_stop_that_was_read_since_is_not_sent() -> None:
    made: list[Slow] = []
    async with robot(making(made, Slow), offers="move_to_shelf") as it:
        with it.stops.typed_at(it.stops.count):
            it.stops.register()
            outcome = await ended(it.send(SHELF, {"shelf_number": 3}))
            queued = await ended(it.send(SHELF, {"shelf_number": 4}, queued=True))
        assert outcome == (Code.CANCELLED, NOT_SENT)
        assert queued == (Code.HELD, NOT_SENT)  # it waits for the operator's word
        assert made[0].goal_ids == []
        assert it.snapshot.goal is None
