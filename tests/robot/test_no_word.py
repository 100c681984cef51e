"""A goal whose server falls silent is missed, whatever else is heard of the robot."""

from __future__ import annotations

from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import MotorStatus
from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.task import Future

from archo_tui.robot.clients import Requester, on_behalf_of
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.goal import Phase
from tests.support import clock
from tests.support.archo import SHELF, go
from tests.support.clock import seconds
from tests.support.plain import operated
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import making, robot

PERIOD = 0.2  # s


class Base(Node):
    """Reports how the wheels turn, and knows no goal."""

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        motion = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(PERIOD, lambda: motion.publish(MotorStatus(moving=True)))


class Planner(Node):
    """Takes goals, and tells how they go on while it is well."""

    def __init__(self, speaks: bool = True, **options: Any) -> None:
        super().__init__("planner", **options)
        self.is_well = speaks
        self.goals: list[Any] = []
        self.never: Future[bool] = Future()
        self.server = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)
        self.create_timer(PERIOD, self.tell)

    async def execute(self, goal: Any) -> Any:
        self.goals.append(goal)
        await self.never

    def tell(self) -> None:
        for goal in self.goals if self.is_well else ():
            goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=9.0))


async def test_its_server_falls_silent_and_the_wheels_vouch_for_nothing() -> None:
    made: list[Any] = []
    async with robot(Base, making(made, Planner)) as it:

        def phase() -> Phase | None:
            return it.snapshot.goal.phase if it.snapshot.goal else None

        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.remaining == 9.0)
        await while_passes(5)
        assert phase() == Phase.MOVING
        made[0].is_well, began = False, seconds()
        await until(lambda: phase() == Phase.LOST)
        assert 2.5 < seconds() - began < 4.5
        assert it.snapshot.motion.received is not None
        assert seconds() - it.snapshot.motion.received < 1.5
        refused = await ended(go(it, 5))
        assert (refused.code, "nothing is heard of the goal" in refused.text) == (
            Code.REFUSED,
            True,
        )
        await while_passes(5)
        assert phase() == Phase.LOST  # the goal is kept
        made[0].is_well = True
        await until(lambda: phase() == Phase.MOVING)


async def test_a_goal_is_not_lost_while_the_console_was_suspended() -> None:
    if clock.current is None:
        pytest.skip("real time passes for all")
    async with operated(Base, Planner) as typed:
        typed.type("go 3\n")
        await typed.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        clock.current.suspend(6.0)
        # The first to go on, before the feedback is read.
        typed._plain._station.robot.check_goals()
        await while_passes(5)
        typed.type("status\n")
        await typed.until("goal MOVING to 3, 9.0 m left")
        assert "LOST" not in typed.said


@pytest.mark.waits
async def test_an_action_that_sends_no_feedback_is_judged_by_its_server_alone() -> None:
    made: list[Any] = []
    async with operated(Base, making(made, Planner, False)) as typed:
        typed.type("go 3\n")
        await typed.until("accepted")
        await while_passes(20)
        typed.type("status\n")
        await typed.until("goal MOVING")
        await typed.until("served, no feedback")


async def test_who_waits_for_its_end_is_told_that_it_is_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.robot.state.goal.GIVEN_UP", 5.0)  # s
    made: list[Any] = []
    async with operated(Base, making(made, Planner)) as typed:
        station, shell = typed._plain._station, Requester("SHELL", "pid 1")
        await until(lambda: "move_to_shelf" in station.robot.snapshot.offered)
        with on_behalf_of(shell):
            assert (await ended(station.goals.drive([QueuedGoal(SHELF, {"shelf_number": 3})]))).ok
        await typed.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        made[0].is_well, began = False, seconds()
        await typed.until("NO WORD FROM GO TO SHELF for")
        (end,) = shell.ends
        outcome = await ended(end)
        assert outcome.code is Code.TIMEOUT
        assert outcome.text.startswith("goal lost: no word from it for ")
        assert 8 <= seconds() - began < 12
        assert station.running_goal is not None
        assert "no word of the goal" in {alarm.name for alarm in station.view.alarms}


async def test_input_that_is_over_waits_for_it_no_longer_and_ends_with_1(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.robot.state.goal.GIVEN_UP", 5.0)  # s
    made: list[Any] = []
    async with operated(Base, making(made, Planner)) as typed:
        typed.type("go 3\n")
        await typed.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        made[0].is_well = False
        assert await typed.end() == 1
        assert "goal lost: no word from it for " in typed.said
