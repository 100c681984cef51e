"""The end of a goal whose node has gone: one rule, wherever the goal came from."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus, GoalStatusArray
from rclpy.node import Node
from unique_identifier_msgs.msg import UUID

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from tests.support.archo import go
from tests.support.by_hand import ByHand
from tests.support.clock import seconds
from tests.support.console import LONG
from tests.support.plain import operated
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.shells import heard, served, typed

LOST = "the robot may still be moving"


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
    made: list[Node] = []
    async with robot(making(made, Node, "somebody")) as it:
        await until(lambda: made[0].executor is not None)
        executor: Any = made[0].executor
        server = Server(context=made[0].context)
        executor.create_task(executor.add_node, server)
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
        back = Server(context=made[0].context)
        executor.create_task(executor.add_node, back)
        executor.create_task(tells, back, goal_id)
        await until(lambda: it.snapshot.running_goal)
        goal = it.snapshot.running_goal
        assert (goal.name, goal.mine) == ("shelf 3", True)
        await until(lambda: back.cancelled)  # A STOP since then ends it, confirmed or not.
        again = "shelf 3 was not lost: its node is heard again"
        await until(lambda: any(event.text == again for event in it.snapshot.events))
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


async def test_of_one_that_crashes_too(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # It is another process there.
    motor = here / "motor.py"
    motor.write_text(
        "from archo_bringup.motor_controller import MotorController\n\n\n"
        "class Motor(MotorController):\n"
        "    def control(self):\n"
        "        super().control()\n"
        "        if self.drive.remaining < 999:\n"
        "            raise RuntimeError('a wheel came off')\n"
    )
    async with operated(node_files=[motor], ros_args=LONG) as person:
        await person.until("the default of motor.py")  # It has taken the place of ARCHO's own.
        person.type("go 12\n")
        await person.until("a wheel came off")  # Its node is off the graph before, on ROS 2.
        assert await person.end() == 1
        assert f"goal LOST, shelf 12, {LOST}" in person.said


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


@pytest.mark.real_time
async def test_a_shell_that_waits_ends_with_1() -> None:
    async with served(ros_args=LONG) as person:
        waiting = asyncio.ensure_future(typed("go", "12", "--wait"))
        await heard(person, "m left of")
        person.type("halt motor_controller --yes\n")
        said = await waiting
        assert (said.code, said.err) == (1, f"accepted\narcho-tui: go: goal lost: {LOST}\n")
