"""A goal of which nothing is heard any more: its server falls silent, or its node has gone."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Any

import pytest
from action_msgs.msg import GoalStatus, GoalStatusArray
from rclpy.node import Node
from unique_identifier_msgs.msg import UUID

from archo_tui.robot.clients import Requester, on_behalf_of
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from tests.support import clock
from tests.support.archo import SHELF, go
from tests.support.by_hand import ByHand
from tests.support.clock import seconds
from tests.support.console import LONG
from tests.support.plain import operated
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import robot, texts
from tests.support.stand_in import Made, StandIn, beside

LOST = "the robot may still be moving"
# The wheels report how they turn and know no goal; a planner takes goals, and is well if it feeds.
Base = partial(Made, StandIn, "base", moving=True)
Planner = partial(Made, StandIn, "planner", goals="drive", feeds=True)


async def test_its_server_falls_silent_and_the_wheels_vouch_for_nothing() -> None:
    planner = Planner()
    async with robot(Base(), planner, offers="move_to_shelf") as it:

        def phase() -> Phase | None:
            return it.snapshot.goal.phase if it.snapshot.goal else None

        assert (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.remaining == 9.0)
        await while_passes(5)
        assert phase() == Phase.MOVING
        planner.node.feeds, began = False, seconds()
        await until(lambda: phase() == Phase.LOST)
        assert 2.5 < seconds() - began < 4.5
        assert it.snapshot.motion.received is not None
        assert seconds() - it.snapshot.motion.received < 1.5
        refused = await ended(go(it, 5))
        assert refused.code is Code.REFUSED
        assert "nothing is heard of the goal" in refused.text
        await while_passes(5)
        assert phase() == Phase.LOST  # the goal is kept
        planner.node.feeds = True
        await until(lambda: phase() == Phase.MOVING)


async def test_a_goal_is_not_lost_while_the_console_was_suspended() -> None:
    if clock.current is None:
        pytest.skip("real time passes for all")
    async with operated(Base(), Planner()) as person:
        person.type("go 3\n")
        await person.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        clock.current.suspend(6.0)
        # The first to go on, before the feedback is read.
        person._plain._station.robot.check_goals()
        await while_passes(5)
        person.type("status\n")
        await person.until("goal MOVING to 3, 9.0 m left")
        assert "LOST" not in person.said


@pytest.mark.waits
async def test_an_action_that_sends_no_feedback_is_judged_by_its_server_alone() -> None:
    async with operated(Base(), Planner(feeds=False)) as person:
        person.type("go 3\n")
        await person.until("accepted")
        await while_passes(20)
        person.type("status\n")
        await person.until("goal MOVING")
        await person.until("served, no feedback")


async def test_who_waits_for_its_end_is_told_that_it_is_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.robot.state.goal.GIVEN_UP", 5.0)  # s
    planner = Planner()
    async with operated(Base(), planner) as person:
        station, shell = person._plain._station, Requester("SHELL", "pid 1")
        await until(lambda: "move_to_shelf" in station.robot.snapshot.offered)
        with on_behalf_of(shell):
            assert (await ended(station.goals.drive([QueuedGoal(SHELF, {"shelf_number": 3})]))).ok
        await person.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        planner.node.feeds, began = False, seconds()
        await person.until("NO WORD FROM GO TO SHELF for")
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
    planner = Planner()
    async with operated(Base(), planner) as person:
        person.type("go 3\n")
        await person.until("9.0 m left")
        await while_passes(2)  # its period is known by then
        planner.node.feeds = False
        assert await person.end() == 1
        assert "goal lost: no word from it for " in person.said


# Its node has gone: one rule, wherever the goal came from.


class Server(ByHand):
    """Takes every goal, and says nothing of it until it is told to."""

    def __init__(self, **options: Any) -> None:
        super().__init__("server", **options)

    async def cancel(self, request: Any, response: Any) -> Any:
        await super().cancel(request, response)
        await self.never
        return response

    def feeds(self, goal_id: bytes) -> None:
        """Tell how far it is from now on, and no status."""
        self.create_timer(0.2, lambda: self.feed(goal_id, 9.0))

    def drives(self, goal_id: bytes) -> None:
        """Tell that it does."""
        status = GoalStatus(status=GoalStatus.STATUS_EXECUTING)
        status.goal_info.goal_id = UUID(uuid=list(goal_id))
        self.status.publish(GoalStatusArray(status_list=[status]))


@pytest.mark.parametrize("tells", [Server.drives, Server.feeds], ids=["status", "feedback"])
async def test_elsewhere_it_is_lost_soon_and_ours_again_when_its_node_is_seen_again(
    tells: Any,
) -> None:
    host = Made(Node, "somebody")
    async with robot(host) as it:
        await until(lambda: host.node.executor is not None)
        executor: Any = host.node.executor
        server = beside(host.node, Server(context=host.node.context))
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it, 3))).ok
        (goal_id,) = server.goal_ids

        def leave(node: Node) -> None:
            executor.remove_node(node)
            node.destroy_node()

        executor.create_task(leave, server)
        began = seconds()
        await until(lambda: it.snapshot.goal and not it.snapshot.goal.is_running)
        assert seconds() - began < 3.0
        goal: Any = it.snapshot.goal
        assert (goal.phase, goal.word, goal.message) == (Phase.GONE, "LOST", LOST)
        assert goal.outcome_at(seconds()) == Outcome(Code.TIMEOUT, f"goal lost: {LOST}")
        it.stops.register()
        back = beside(host.node, Server(context=host.node.context))
        executor.create_task(tells, back, goal_id)
        await until(lambda: it.snapshot.running_goal)
        goal = it.snapshot.running_goal
        assert (goal.name, goal.mine) == ("shelf 3", True)
        await until(lambda: back.cancelled)  # A STOP since then ends it, confirmed or not.
        again = "shelf 3 was not lost: its node is heard again"
        await until(lambda: again in texts(it))
        said = [event.text for event in it.snapshot.events if event.level == "GOAL"]
        assert said == [f"shelf 3 lost: {LOST}", again]
        executor.create_task(leave, back)
        await until(lambda: it.snapshot.running_goal is None)


async def test_of_a_halted_node_it_is_lost_at_once_and_the_rest_is_held() -> None:
    async with operated(ros_args=LONG) as person:
        person.type("go 12 7\n")
        await person.until("m left of")
        began = seconds()
        person.type("halt motor_controller --yes\n")
        await person.until(f"goal LOST, shelf 12, {LOST}")
        assert seconds() - began < 0.5
        assert await person.end() == 1
        assert "queue held: 7 (lost)" in person.said
        assert "not driven: 7 (lost)" in person.said


async def test_a_copy_that_is_halted_takes_no_goal_of_the_other_one_along() -> None:
    async with operated(ros_args=LONG) as person:
        person.type("go 12\n")
        await person.until("m left of")
        host = person._plain._station.host
        assert (await asyncio.to_thread(host.copy_node, "/motor_controller")).ok
        person.type("halt motor_controller_2 --yes\nnodes\n")
        await person.until("motor_controller_2 stopped")
        goal = person._plain._robot.snapshot.goal
        assert goal is not None
        assert goal.is_running
