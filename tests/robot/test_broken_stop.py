"""A STOP that is refused, hangs, or has gone: the goals are cancelled all the same."""

from __future__ import annotations

import asyncio
import contextlib
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import MotorStatus
from archo_interfaces.srv import EmergencyStop
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future

from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Latch
from archo_tui.robot_file.load import default_path
from archo_tui.text.goal import goal_line
from tests.robot.test_several_servers import Brake
from tests.support import clock
from tests.support.archo import go
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.ros import begin

LATE = "yes, after 5 s"


class Driver(Node):
    """Drives until it is cancelled; serves a STOP that says yes, no, or nothing, and is heard."""

    def __init__(
        self, says: str = "", *, moves: bool | None = False, heeds: bool = True, **options: Any
    ) -> None:
        super().__init__("driver", **options)
        self.says, self.moves, self.heeds = says, moves, heeds
        self.stops: list[float] = []
        self.cancelled: list[float] = []
        self.goal_ids: list[bytes] = []
        self.never: Future[bool] = Future()
        group = ReentrantCallbackGroup()
        if says:
            self.create_service(EmergencyStop, "emergency_stop", self.stop, callback_group=group)
        self.motion = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(0.2, self.report, callback_group=group)
        self.action = ActionServer(
            self,
            MoveToShelf,
            "move_to_shelf",
            self.drive,
            callback_group=group,
            cancel_callback=self.cancel,
        )

    def report(self) -> None:
        if self.moves is not None:
            self.motion.publish(MotorStatus(moving=self.moves))

    async def stop(self, _: Any, response: EmergencyStop.Response) -> EmergencyStop.Response:
        self.stops.append(clock.seconds())
        if self.says == "nothing":
            await self.never
        if self.says == LATE:
            await self.sleep(5.0)
        response.success, response.message = self.says != "no", self.says
        return response

    async def sleep(self, seconds: float) -> None:
        over: Future[bool] = Future(executor=self.executor)
        timer = self.create_timer(seconds, lambda: over.set_result(True))
        await over
        self.destroy_timer(timer)

    def cancel(self, _: Any) -> CancelResponse:
        self.cancelled.append(clock.seconds())
        return CancelResponse.ACCEPT if self.heeds else CancelResponse.REJECT

    async def drive(self, goal: Any) -> MoveToShelf.Result:
        self.goal_ids.append(bytes(goal.goal_id.uuid))
        while not goal.is_cancel_requested:
            goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=9.0))
            await self.sleep(0.1)
        goal.canceled()
        return MoveToShelf.Result(final_message="called back")


class Other(Node):
    """Another client, which sends goals of its own."""

    def __init__(self, **options: Any) -> None:
        super().__init__("other", **options)
        self.client = ActionClient(self, MoveToShelf, "move_to_shelf")

    def go(self, goals: int = 1) -> None:
        for shelf in range(goals):
            self.client.send_goal_async(MoveToShelf.Goal(shelf_number=shelf + 1))


def texts(it: Any) -> list[str]:
    return [event.text for event in it.snapshot.events]


async def pass_time(seconds: float) -> None:
    later = clock.seconds() + seconds
    await until(lambda: clock.seconds() > later)


@pytest.mark.parametrize("says", ["no", "nothing", LATE, ""])
async def test_a_goal_is_cancelled_whatever_the_stop_answers(says: str) -> None:
    made: list[Driver] = []
    more = [partial(Brake, "second_stop")] if says == LATE else []
    async with robot(making(made, Driver, says), *more, offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        sent = clock.seconds()
        stop = it.emergency_stop()
        assert not (await ended(stop)).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase is Phase.CANCELLED)
        assert made[0].cancelled[0] - sent < 1.0
        made[0].never.set_result(True)


async def test_a_stop_that_is_called_off_answers_for_none_behind_it() -> None:
    async with robot(making([], Driver, "nothing"), offers="move_to_shelf") as it:
        it.stops.register()
        sent = asyncio.ensure_future(it.emergency_stop())
        await asyncio.sleep(0)
        it.stops.register()  # Of the next one, whose work has not begun.
        sent.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await sent
        assert it.stops.answered == 1
        assert not it.stops.are_answered


async def test_a_stop_does_not_cancel_a_goal_that_the_robot_ends_by_itself() -> None:
    class Aborts(Driver):
        async def drive(self, goal: Any) -> MoveToShelf.Result:
            while not self.stops:
                await self.sleep(0.05)
            goal.abort()
            return MoveToShelf.Result(final_message="stopped")

    made: list[Aborts] = []
    async with robot(making(made, Aborts, "yes"), offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        assert (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.goal and not it.snapshot.goal.is_running)
        await pass_time(3.0)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase is Phase.ABORTED
        assert made[0].cancelled == []


async def test_the_cancel_of_a_stop_changes_no_phase() -> None:
    made: list[Driver] = []
    seen = set()
    maker = making(made, lambda **options: Driver("no", heeds=False, **options))
    async with robot(maker, offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        assert not (await ended(it.emergency_stop())).ok

        def is_asked_again() -> bool:
            assert it.snapshot.goal is not None
            seen.add(it.snapshot.goal.phase)
            return len(made[0].cancelled) >= 3

        await until(is_asked_again)
        assert seen == {Phase.MOVING}


async def test_an_action_whose_cancel_moves_the_robot_is_exempt(tmp_path: Path) -> None:
    made: list[Driver] = []
    file = tmp_path / "exempt.yaml"
    text = default_path().read_text()
    file.write_text(
        text.replace("action: move_to_shelf\n", "action: move_to_shelf\n    stop_cancels: false\n")
    )
    async with robot(making(made, Driver, "no"), robot=file, offers="move_to_shelf") as it:
        kind = it.file.goals[0]
        assert not kind.stop_cancels
        assert (await ended(it.send(kind, {"shelf_number": 3}))).ok
        assert not (await ended(it.emergency_stop())).ok
        await pass_time(4.0)
        assert made[0].cancelled == []
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.is_running
        line = "".join(text for text, _ in goal_line(it.snapshot, clock.seconds(), ""))
        assert "STOP does not cancel it" in line


@pytest.mark.parametrize("says", ["no", "nothing", ""])
async def test_goals_of_other_clients_are_cancelled_a_second_after_a_stop_without_a_yes(
    says: str,
) -> None:
    made: list[Driver] = []
    others: list[Other] = []
    async with robot(
        making(made, Driver, says), making(others, Other), offers="move_to_shelf"
    ) as it:
        begin(others[0], others[0].go, 3)
        await until(lambda: it.snapshot.running == 3)
        sent = clock.seconds()
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.running == 0)
        assert 0.9 < made[0].cancelled[0] - sent < 1.5
        said = "STOP was not confirmed in time: cancelling 3 goals of other clients"
        await until(lambda: said in texts(it))
        await pass_time(3.0)
        assert sum("goals of other clients" in text for text in texts(it)) == 1
        made[0].never.set_result(True)


async def test_goals_of_other_clients_are_left_to_a_robot_that_says_yes() -> None:
    made: list[Driver] = []
    others: list[Other] = []
    async with robot(
        making(made, Driver, "yes"), making(others, Other), offers="move_to_shelf"
    ) as it:
        begin(others[0], others[0].go)
        await until(lambda: it.snapshot.running == 1)
        assert (await ended(it.emergency_stop())).ok
        await pass_time(3.0)
        assert made[0].cancelled == []
        assert it.snapshot.still_running_after_stop == ("another client's goal",)


async def test_what_others_send_behind_a_stop_goes_on_even_if_it_is_given_up() -> None:
    made: list[Driver] = []
    others: list[Other] = []
    maker = making(made, lambda **options: Driver("no", heeds=False, **options))
    async with robot(maker, making(others, Other), offers="move_to_shelf") as it:
        begin(others[0], others[0].go)
        await until(lambda: it.snapshot.running == 1)
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: made[0].cancelled)
        begin(others[0], others[0].go)
        await until(lambda: it.snapshot.running == 2)
        await until(lambda: len(made[0].cancelled) >= 3)
        assert it.snapshot.running == 2
        assert (await ended(it.give_up_stop())).ok
        before = len(made[0].cancelled)
        await pass_time(5.0)
        assert len(made[0].cancelled) <= before + 1  # one may have been on its way


async def test_a_stop_that_is_pressed_again_cancels_what_others_have_sent_since() -> None:
    made: list[Driver] = []
    others: list[Other] = []
    async with robot(
        making(made, Driver, "no"), making(others, Other), offers="move_to_shelf"
    ) as it:
        begin(others[0], others[0].go)
        await until(lambda: it.snapshot.running == 1)
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.running == 0)
        begin(others[0], others[0].go)
        await until(lambda: it.snapshot.running == 1)
        await pass_time(2.5)
        assert it.snapshot.running == 1  # A repeat is no new word of the operator.
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.running == 0)


async def test_a_server_that_leaves_without_an_answer_makes_the_stop_uncertain() -> None:
    made: list[Brake] = []
    hangs = making(made, Brake, "hangs", "nothing")
    async with robot(lambda **o: Driver("yes", **o), hangs) as it:
        await until(lambda: "emergency_stop" in it.snapshot.duplicate_servers)
        assert not (await ended(it.emergency_stop())).ok
        begin(made[0], made[0].leave)
        await until(lambda: it.snapshot.open_stop is None)
        assert it.snapshot.latch is Latch.UNCERTAIN
        assert it.snapshot.latch_doubt == "/hangs has left without an answer"
        made[0].awake.set_result(True)
