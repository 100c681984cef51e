"""A release or a goal that left before a STOP, and that a busy robot takes behind it."""

from __future__ import annotations

import asyncio
import math
from typing import Any

import pytest
from archo_interfaces.srv import EmergencyStop
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from archo_tui.robot import node
from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.snapshot import Latch
from archo_tui.robot.stop.gate import NOT_SENT
from tests.support import clock
from tests.support.archo import SHELF, go
from tests.support.by_hand import ByHand
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.ros import begin


class Busy(Node):
    """Takes a release only when it is woken, and every STOP at once."""

    def __init__(self, **options: Any) -> None:
        super().__init__("busy", **options)
        self.latched, self.asked = True, 0
        self.awake: Future[bool] = Future()
        group = ReentrantCallbackGroup()
        name = "release_emergency_stop"
        self.create_service(EmergencyStop, "emergency_stop", self.stop, callback_group=group)
        self.create_service(Trigger, name, self.release, callback_group=group)
        self.create_timer(0.1, lambda: None)  # rclpy looks at what waits when it is awake

    def stop(self, _: Any, response: EmergencyStop.Response) -> EmergencyStop.Response:
        self.latched = True
        response.success, response.message = True, "Stopped"
        return response

    async def release(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        self.asked += 1
        await self.awake
        self.latched = False
        response.success, response.message = True, "Released"
        return response

    def wake(self) -> None:
        begin(self, lambda: self.awake.set_result(True))


def by_its_key(it: Robot) -> Any:
    return it.release_emergency_stop()


def by_a_form(it: Robot) -> Any:
    return it.call("/release_emergency_stop", "std_srvs/srv/Trigger", {})


# behind 2 s without an answer the console has given the release up; the robot has not
@pytest.mark.parametrize(("how", "wait"), [(by_its_key, 0.3), (by_its_key, 3.0), (by_a_form, 0.3)])
async def test_a_release_that_is_taken_behind_a_stop_is_followed_by_another_stop(
    how: Any, wait: float
) -> None:
    made: list[Busy] = []
    async with robot(making(made, Busy), offers="emergency_stop release_emergency_stop") as it:
        task = asyncio.ensure_future(how(it))
        await until(lambda: made[0].asked == 1)
        stop = clock.seconds() + wait
        await until(lambda: clock.seconds() >= stop)
        it.stops.register()
        assert (await ended(it.emergency_stop())).ok
        made[0].wake()
        await until(lambda: any("sent again behind" in event.text for event in it.snapshot.events))
        await until(task.done)
        assert made[0].latched


async def test_a_release_that_is_answered_late_ends_the_stop() -> None:
    made: list[Busy] = []
    async with robot(making(made, Busy), offers="emergency_stop release_emergency_stop") as it:
        assert (await ended(it.emergency_stop())).ok
        assert (await ended(it.release_emergency_stop())).code == Code.TIMEOUT
        assert it.snapshot.latch is Latch.HELD
        made[0].wake()
        await until(lambda: it.snapshot.latch is Latch.NONE)


class Released(Busy):
    """Can be released, but not stopped: the node that has the STOP has left."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        named = [one for one in self.services if one.service_name.endswith("/emergency_stop")]
        self.destroy_service(named[0])


async def test_an_earlier_release_does_not_end_a_stop_that_cannot_be_sent() -> None:
    made: list[Released] = []
    async with robot(making(made, Released), offers="release_emergency_stop") as it:
        release = asyncio.ensure_future(by_its_key(it))
        await until(lambda: made[0].asked == 1)
        it.stops.register()
        stop = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: it.snapshot.open_stop is not None)
        made[0].wake()
        assert (await ended(release)).ok
        assert (await ended(stop)).code == Code.NOT_OFFERED
        assert it.snapshot.open_stop is not None


async def test_an_open_stop_finds_its_server_before_the_graph_is_polled_again() -> None:
    made: list[Node] = []
    async with robot(making(made, Node, "somebody")) as it:
        it.stops.register()
        assert (await ended(it.emergency_stop())).code == Code.NOT_OFFERED
        it._poller._next = math.inf  # As on a graph of many names, which rests long.
        await until(lambda: made[0].executor is not None)
        executor: Any = made[0].executor
        executor.create_task(executor.add_node, Busy(context=made[0].context))
        await until(lambda: it.snapshot.open_stop is None)
        assert it.snapshot.latch is Latch.HELD


async def test_a_release_typed_behind_a_stop_is_not_followed_by_a_stop() -> None:
    made: list[Busy] = []
    async with robot(making(made, Busy), offers="emergency_stop") as it:
        assert (await ended(it.emergency_stop())).ok
        made[0].wake()
        assert (await ended(it.release_emergency_stop())).ok
        later = clock.seconds() + 1.0
        await until(lambda: clock.seconds() >= later)
        assert not made[0].latched


async def test_a_stop_is_sent_again_however_late_the_release_before_it_is_answered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(node, "LATE", 2.5)  # what a late answer to a STOP has
    made: list[Busy] = []
    async with robot(making(made, Busy), offers="emergency_stop release_emergency_stop") as it:
        task = asyncio.ensure_future(by_its_key(it))
        await until(task.done)
        it.stops.register()
        assert (await ended(it.emergency_stop())).ok
        later = clock.seconds() + 3 * node.LATE
        await until(lambda: clock.seconds() >= later)
        made[0].wake()
        await until(lambda: any("sent again behind" in event.text for event in it.snapshot.events))
        assert made[0].latched


# A goal that was typed before a STOP, wherever it is by then.


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
