"""A robot whose file names no STOP: its key cancels every goal, and never calls that a STOP."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("depot_interfaces")

from action_msgs.srv import CancelGoal
from depot_interfaces.action import Dock
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future

import archo_tui
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.goal import Phase
from archo_tui.robot_file.load import load
from tests.robots.rover import Rover
from tests.support.console import console, console_with
from tests.support.plain import operated
from tests.support.quiet import ended, until
from tests.support.robot import robot
from tests.support.shells import served, typed
from tests.support.stand_in import Made

FILE = Path(__file__).with_name("rover.yaml")
GO = load(FILE).goals[0]
THERE = {"target.pose.position.x": 9.0, "target.pose.position.y": 0.0}
NONE = "Rover has no STOP: use the hardware stop (this is not a STOP: "


async def moving(it: Robot) -> None:
    """Have the rover drive."""
    await until(lambda: {"go_to", "dock", "undock"} <= it.snapshot.offered)
    turned = {"target.pose.orientation": 0.0}
    assert (await ended(it.send(GO, {**THERE, **turned}))).ok
    await until(lambda: phase_of(it) is Phase.MOVING)


def phase_of(it: Robot) -> Phase | None:
    return None if it.snapshot.goal is None else it.snapshot.goal.phase


class Silent(Node):
    """Serves an action that the robot file does not name, and answers no cancel."""

    def __init__(self, **options: Any) -> None:
        super().__init__("silent", **options)
        self.asked = 0
        self.awake: Future[bool] = Future()
        group, impl = ReentrantCallbackGroup(), Dock.Impl
        self.create_publisher(impl.FeedbackMessage, "asleep/_action/feedback", 10)
        self.create_service(impl.SendGoalService, "asleep/_action/send_goal", lambda *_: None)
        name = "asleep/_action/cancel_goal"
        self.create_service(CancelGoal, name, self.cancel, callback_group=group)

    async def cancel(self, _: Any, response: Any) -> Any:
        self.asked += 1
        await self.awake
        return response


async def test_a_server_that_does_not_answer_keeps_no_other_goal_running() -> None:
    made = Made(Silent)
    async with robot(Rover, made, robot=FILE) as it:
        await moving(it)
        await until(lambda: "/asleep" in it.snapshot.actions)
        it.stops.register()
        stop = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: phase_of(it) is Phase.CANCELLED)
        assert not stop.done()
        outcome = await ended(stop)
        assert outcome.text == f"{NONE}no answer to the cancel in 2 s: /asleep)"
        assert made.node.asked == 1
        made.node.awake.set_result(True)


async def test_goals_that_wait_are_held_behind_it() -> None:
    made = Made(Rover)
    async with operated(made, robot=FILE) as person:
        person.type("go x=1 y=2 yaw=0\ngo x=3 y=4 yaw=0\n")
        await person.until("goal MOVING")
        await person.until("queue: ")
        person.type("stop\n")
        await person.until(f"failed: stop: {NONE}cancelling 1 goal)")
        await person.until("goal CANCELLED")
        await person.until("held")
        assert [target.pose.position.x for target in made.node.heard] == [1.0]
        assert await person.end("") == 1


@pytest.mark.real_time
async def test_a_shell_and_python_are_told_that_it_was_no_stop() -> None:
    async with served(Rover, robot=FILE):
        said = await typed("stop")
        assert said.code != 0
        assert f"{NONE}none was cancelled)" in said.err

        def stop() -> str:
            with archo_tui.connect() as rover:
                try:
                    rover.stop()
                except archo_tui.NotDone as failed:
                    return str(failed)
            return "stopped"

        assert f"{NONE}none was cancelled)" in await asyncio.to_thread(stop)


async def test_its_screen_names_what_the_key_does_and_nothing_that_releases() -> None:
    async with console_with(Rover, "go_to", robot=FILE) as (op, node):
        await op.until("^x cancel all")
        assert "no STOP" in op.line(" Rover ")
        assert "Cancel all" in op.line("Cancel all")
        assert "STOP" not in op.text.replace("no STOP", "")
        assert "R release" not in op.text
        node.is_held = True
        await op.press("g", *"1.5", "enter", *"-2", "enter", *"90", "enter")
        await op.until("m left of")
        await op.press("ctrl+x")
        await op.until("Rover has no STOP: use the hardware stop")
        await op.until("this is not a STOP")
        await op.until("✗ CANCELLED")
        assert "STOPPED" not in op.text


@pytest.mark.parametrize("size", [(80, 24), (120, 36)])
async def test_the_longest_title_of_a_command_leaves_the_stop_its_place(
    size: tuple[int, int], here: Path
) -> None:
    file = here / "robot.yaml"
    file.write_text(
        "name: Long\nstop: {service: halt}\ncommands:\n"
        f"  - {{id: map, title: Save {'the whole map ' * 9}, key: m, service: map}}\n"
    )
    async with console(robot=file, node_makers=[Rover], size=size, wait=False) as op:
        await op.until("Save the")
        assert " STOP " in op.line("Save the")
