"""Robot's verbs all end: done, refused with the reason, or no answer. No screen here."""

from __future__ import annotations

import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from archo_interfaces.action import MoveToShelf
from archo_interfaces.srv import ResetEncoder
from rclpy.action import ActionServer
from rclpy.node import Node
from std_msgs.msg import Float32

from archo_tui.robot.client import Robot
from archo_tui.robot.state import Phase
from archo_tui.session import Options, Session
from tests.support import chosen, clock
from tests.support.quiet import ended, until


@asynccontextmanager
async def robot(*makers: Callable[..., Node], nodes: int | None = None) -> AsyncIterator[Robot]:
    """A Robot beside these nodes."""
    options = Options(engine=chosen.ENGINE, domain_id=chosen.next_domain(), node_makers=makers)
    with Session(options, clock.current) as session:
        await until(lambda: len(session.robot.snapshot.nodes) == (nodes or len(makers)) + 1)
        yield session.robot


def server(*, hang: threading.Event | None = None, end: str = "succeed") -> Any:
    """A node with the encoder service and the action; may hang in both."""

    class Server(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("server", **options)
            self.create_service(ResetEncoder, "reset_encoder", self.reset)
            self.action = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)

        def reset(self, request: Any, response: Any) -> Any:
            if hang is not None:
                with clock.stuck():
                    hang.wait(30)
            response.success, response.message = False, "the encoder is stuck"
            return response

        def execute(self, goal: Any) -> Any:
            if hang is not None:
                with clock.stuck():
                    hang.wait(30)
            getattr(goal, end)()
            return MoveToShelf.Result(final_message="that was it")

    return Server


def quiet(**options: Any) -> Node:
    return Node("quiet", **options)


async def test_what_nobody_offers_is_said() -> None:
    async with robot(quiet) as it:
        outcome = await ended(it.reset_encoder())
        assert (outcome.ok, outcome.text) == (False, "/reset_encoder is not offered by any node")
        outcome = await ended(it.cancel())
        assert (outcome.ok, outcome.text) == (False, "no goal is running")


async def test_the_servers_own_refusal_is_passed_on() -> None:
    async with robot(server()) as it:
        await until(lambda: "reset_encoder" in it.snapshot.offered)
        outcome = await ended(it.reset_encoder())
        assert (outcome.ok, outcome.text) == (False, "the encoder is stuck")


async def test_a_server_that_hangs_gives_no_answer_and_the_next_call_works() -> None:
    hang = threading.Event()
    async with robot(server(hang=hang)) as it:
        await until(lambda: "reset_encoder" in it.snapshot.offered)
        outcome = await ended(it.reset_encoder())
        assert not outcome.ok
        assert outcome.text.startswith("no answer in ")
        hang.set()
        assert (await ended(it.reset_encoder())).text == "the encoder is stuck"


async def test_a_server_that_nobody_spins_gives_no_answer() -> None:
    unspun: list[Node] = []

    def make(**options: Any) -> Node:
        unspun.append(server()(**options))
        return quiet(**options)

    async with robot(make, nodes=2) as it:
        await until(lambda: {"reset_encoder", "move_to_shelf"} <= it.snapshot.offered)
        assert (await ended(it.reset_encoder())).text.startswith("no answer in ")
        assert (await ended(it.go_to_shelf(3))).text.startswith("no answer in ")
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.UNKNOWN
        assert (await ended(it.cancel())).text.startswith("no answer in ")
        unspun[0].destroy_node()


async def test_a_goal_that_a_new_server_does_not_know_has_ended() -> None:
    made: list[Node] = []

    def make(**options: Any) -> Node:
        made.append(server()(**options))  # never spun, as good as dead
        made.append(quiet(**options))
        return made[1]

    async with robot(make, nodes=2) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        await ended(it.go_to_shelf(3))
        made[0].destroy_node()
        reborn = server()(context=made[1].context)
        executor = made[1].executor
        assert executor is not None
        executor.create_task(executor.add_node, reborn)
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ABORTED)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message.startswith("the robot no longer knows this goal")
        reborn.destroy_node()


async def test_a_goal_without_an_answer_is_unknown_until_the_robot_says_more() -> None:
    hang = threading.Event()
    async with robot(server(hang=hang)) as it:
        await until(lambda: "reset_encoder" in it.snapshot.offered)
        await ended(it.reset_encoder())  # the server hangs in this one, and has not seen the goal
        outcome = await ended(it.go_to_shelf(3))
        assert not outcome.ok
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.UNKNOWN
        assert it.snapshot.goal.is_running
        hang.set()
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ARRIVED)


@pytest.mark.parametrize(("end", "phase"), [("succeed", Phase.ARRIVED), ("abort", Phase.ABORTED)])
async def test_a_goal_ends_as_the_server_says(end: str, phase: Phase) -> None:
    async with robot(server(end=end)) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(it.go_to_shelf(3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == phase)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message == "that was it"
        assert [goal.shelf for goal in it.snapshot.history] == [3]
        assert GoalStatus.STATUS_ABORTED == 6


async def test_a_cancel_that_the_server_rejects_is_said_and_the_goal_goes_on() -> None:
    class Stubborn(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("stubborn", **options)
            self.action = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)
            self.timer = self.create_timer(0.01, lambda: None)

        async def execute(self, goal: Any) -> Any:
            from rclpy.task import Future

            self.released: Future[bool] = Future()
            await self.released
            goal.succeed()
            return MoveToShelf.Result(success=True, final_message="went on")

    made: list[Stubborn] = []

    def make(**options: Any) -> Node:
        made.append(Stubborn(**options))
        return made[0]

    async with robot(make) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(it.go_to_shelf(3))).ok
        await until(lambda: hasattr(made[0], "released"))
        outcome = await ended(it.cancel())
        assert not outcome.ok
        assert outcome.text.startswith("the robot rejected the cancel")
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.MOVING
        made[0].released.set_result(True)
        await until(lambda: it.snapshot.goal and it.snapshot.goal.message == "went on")


async def test_the_textbooks_float32_battery_is_heard_too() -> None:
    class Float(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("float", **options)
            publisher = self.create_publisher(Float32, "battery_level", 10)
            self.create_timer(0.02, lambda: publisher.publish(Float32(data=55.5)))

    async with robot(Float) as it:
        await until(lambda: it.snapshot.battery.percentage == 55.5)
        assert (it.snapshot.battery.voltage, it.snapshot.battery.health) == (None, None)


async def test_parameters_of_a_node_that_comes_and_goes_come_and_go() -> None:
    made: list[Node] = []

    def make(**options: Any) -> Node:
        made.append(Node("guest", **options))
        made[0].declare_parameter("number", 1)
        return made[0]

    async with robot(make) as it:
        await until(lambda: it.snapshot.parameter("number"))
        outcome = await it.set_parameters("/guest", {"number": 2})
        assert (outcome.ok, outcome.text) == (True, "number is 2")
        parameter = it.snapshot.parameter("number")
        assert parameter is not None
        assert (parameter.value, parameter.initial, parameter.is_changed) == (2, 1, True)
        made[0].declare_parameter("later", "x")
        await until(lambda: it.snapshot.parameter("later"))
        made[0].destroy_node()
        await until(lambda: it.snapshot.parameter("number") is None)


async def test_every_verb_leaves_a_line_with_its_ros2_command() -> None:
    async with robot(server()) as it:
        await until(lambda: "reset_encoder" in it.snapshot.offered)
        await ended(it.reset_encoder())
        await it.set_parameters("/server", {"use_sim_time": True})
        await ended(it.go_to_shelf(7))
        await until(lambda: len([e for e in it.snapshot.events if e.level == "YOU"]) == 3)
        assert [e.command for e in it.snapshot.events if e.level == "YOU"] == [
            'ros2 service call /reset_encoder archo_interfaces/srv/ResetEncoder "{}"',
            "ros2 param set /server use_sim_time true",
            "ros2 action send_goal /move_to_shelf archo_interfaces/action/MoveToShelf "
            '"{shelf_number: 7}" --feedback',
        ]


async def test_a_topic_of_an_unknown_type_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from archo_tui.robot import interfaces

    real = interfaces.load
    monkeypatch.setattr(
        interfaces, "load", lambda name: None if name == "std_msgs/msg/Float32" else real(name)
    )

    def make(**options: Any) -> Node:
        node = Node("float", **options)
        node.create_publisher(Float32, "battery_level", 10)
        return node

    async with robot(make) as it:
        said = "battery_level cannot be heard: its type std_msgs/msg/Float32 is not installed here"
        await until(lambda: [e.text for e in it.snapshot.events] == [said])
        await until(lambda: len(it.snapshot.nodes) == 2)
        assert [e.count for e in it.snapshot.events] == [1]
