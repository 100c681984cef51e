"""Robot's verbs all end: done, refused with the reason, or no answer. No screen here."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from archo_interfaces.action import MoveToShelf
from archo_interfaces.srv import EmergencyStop, ResetEncoder
from rclpy.action import ActionServer, GoalResponse
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from std_msgs.msg import Float32
from std_srvs.srv import Empty, SetBool

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.goal import Phase
from tests.support import chosen, clock
from tests.support.archo import go, reset
from tests.support.by_hand import ByHand
from tests.support.quiet import ended, until
from tests.support.robot import making, robot
from tests.support.ros import begin

FIVE: Parameter[int] = Parameter("number", value=5)


def publishing(kind: Any, quality: Any = 10, **fields: Any) -> Any:
    """A node that publishes a battery's level, again and again."""

    class Publishing(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("publishing", **options)
            publisher = self.create_publisher(kind, "battery_level", quality)
            self.create_timer(0.05, lambda: publisher.publish(kind(**fields)))

    return Publishing


def driving(execute: Callable[[Any], Any], **callbacks: Any) -> Any:
    """A node with the action, whose goals are executed so."""

    class Driving(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("driving", **options)
            self.goals: list[Any] = []
            self.action = ActionServer(
                self, MoveToShelf, "move_to_shelf", self.execute, **callbacks
            )
            self.create_timer(0.5, lambda: None)  # What is awaited is noticed when it wakes.

        async def execute(self, goal: Any) -> Any:
            self.goals.append(goal)
            result = execute(goal)
            return await result if isinstance(result, Future) else result

    return Driving


def stopping(kind: Any, stop: Callable[[Any, Any], Any]) -> Any:
    """A node with a STOP of that type."""

    class Stopping(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("stopping", **options)
            self.create_service(kind, "emergency_stop", stop)

    return Stopping


def yes(_: Any, response: Any) -> Any:
    response.success, response.message = True, "Stopped"
    return response


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
            return MoveToShelf.Result(success=end == "succeed", final_message="that was it")

    return Server


def quiet(**options: Any) -> Node:
    return Node("quiet", **options)


async def test_what_nobody_offers_is_said() -> None:
    async with robot(quiet) as it:
        assert it.snapshot.offered == frozenset()
        outcome = await ended(reset(it))
        assert outcome == (Code.NOT_OFFERED, "/reset_encoder is not offered by any node")
        outcome = await ended(it.cancel())
        assert outcome == (Code.REFUSED, "no goal is running")


async def test_the_servers_own_refusal_is_passed_on() -> None:
    async with robot(server(), offers="reset_encoder") as it:
        outcome = await ended(reset(it))
        assert outcome == (Code.REFUSED, "the encoder is stuck")


async def test_a_server_that_nobody_spins_gives_no_answer() -> None:
    unspun: list[Node] = []

    def make(**options: Any) -> Node:
        unspun.append(server()(**options))
        return quiet(**options)

    async with robot(make, nodes=2, offers="reset_encoder move_to_shelf") as it:
        assert (await ended(reset(it))).text.startswith("no answer in ")
        assert (await ended(go(it, 3))).text.startswith("no answer in ")
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.UNKNOWN
        assert (await ended(it.cancel())).text == "no answer to the cancel in 4 s"
        unspun[0].destroy_node()


async def test_a_goal_that_a_new_server_does_not_know_has_ended() -> None:
    made: list[Any] = []

    def make(**options: Any) -> Any:
        made.append(server()(**options))  # never spun, as good as dead
        made.append(quiet(**options))
        return made[1]

    async with robot(make, nodes=2, offers="move_to_shelf") as it:
        await ended(go(it, 3))
        made[0].action.destroy()  # rclpy leaves it on the graph when its node is destroyed
        made[0].destroy_node()
        reborn = server()(context=made[1].context)
        begin(made[1], made[1].executor.add_node, reborn)
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ABORTED)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message.startswith("the robot does not know this goal")
        reborn.destroy_node()


async def test_a_goal_without_an_answer_is_unknown_until_the_robot_says_more() -> None:
    hang = threading.Event()
    async with robot(server(hang=hang), offers="reset_encoder") as it:
        hung = await ended(reset(it))  # the server hangs in it, and has not seen the goal
        assert (hung.code, hung.text[:13]) == (Code.TIMEOUT, "no answer in ")
        outcome = await ended(go(it, 3))
        assert not outcome.ok
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.UNKNOWN
        assert it.snapshot.goal.is_running
        hang.set()
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ARRIVED)
        assert (await ended(reset(it))).text == "the encoder is stuck"


@pytest.mark.parametrize(("end", "phase"), [("succeed", Phase.ARRIVED), ("abort", Phase.ABORTED)])
async def test_a_goal_ends_as_the_server_says(end: str, phase: Phase) -> None:
    async with robot(server(end=end), offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == phase)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message == "that was it"
        assert [goal.target for goal in it.snapshot.history] == ["3"]
        assert GoalStatus.STATUS_ABORTED == 6


async def test_a_cancel_that_the_server_rejects_is_said_and_the_goal_goes_on() -> None:
    made: list[Any] = []
    released: Future[Any] = Future()
    async with robot(making(made, driving(lambda _: released)), offers="move_to_shelf") as it:
        assert (await ended(go(it, 3))).ok
        await until(lambda: made[0].goals)
        outcome = await ended(it.cancel())
        assert not outcome.ok
        assert outcome.text.startswith("the robot rejected the cancel")
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.MOVING
        made[0].goals[0].succeed()
        begin(made[0], released.set_result, MoveToShelf.Result(success=True, final_message="on"))
        await until(lambda: it.snapshot.goal and it.snapshot.goal.message == "on")


@pytest.mark.parametrize(
    "quality", [10, QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)]
)
async def test_a_float32_battery_is_heard_however_it_is_published(quality: Any) -> None:
    async with robot(publishing(Float32, quality, data=55.5)) as it:
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
        assert outcome == (Code.DONE, "number is 2, was 1")
        parameter = it.snapshot.parameter("number")
        assert parameter is not None
        assert (parameter.value, parameter.initial, parameter.is_changed) == (2, 1, True)
        made[0].declare_parameter("later", "x")
        await until(lambda: it.snapshot.parameter("later"))
        made[0].destroy_node()
        await until(lambda: it.snapshot.parameter("number") is None)


async def test_every_verb_leaves_a_line_with_its_ros2_command() -> None:
    async with robot(server(), offers="reset_encoder") as it:
        await ended(reset(it))
        await it.set_parameters("/server", {"use_sim_time": True})
        await ended(go(it, 7))
        await until(lambda: len([e for e in it.snapshot.events if e.level == "YOU"]) == 3)
        assert [e.command for e in it.snapshot.events if e.level == "YOU"] == [
            "ros2 service call /reset_encoder archo_interfaces/srv/ResetEncoder '{}'",
            "ros2 param set /server use_sim_time true",
            "ros2 action send_goal /move_to_shelf archo_interfaces/action/MoveToShelf "
            "'{shelf_number: 7}' --feedback",
        ]


async def test_a_topic_of_an_unknown_type_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from archo_tui.robot.messages.types import load_class

    real = load_class
    monkeypatch.setattr(
        "archo_tui.robot.telemetry.load_class",
        lambda name: None if name == "std_msgs/msg/Float32" else real(name),
    )

    def make(**options: Any) -> Node:
        node = Node("float", **options)
        node.create_publisher(Float32, "battery_level", 10)
        return node

    async with robot(make) as it:
        said = "battery_level is std_msgs/msg/Float32, which is not installed here"
        await until(lambda: [e.text for e in it.snapshot.events] == [said])
        await until(lambda: len(it.snapshot.nodes) == 1)
        assert [e.count for e in it.snapshot.events] == [1]


class Sluggish(ByHand):
    """Answers the first goal only at last, and knows nothing of it meanwhile; the next at once."""

    def __init__(self, **options: Any) -> None:
        super().__init__("sluggish", **options)
        self.at_last: Future[bool] = Future()
        self.answered = 0
        self.create_timer(0.2, self.tell)

    def tell(self) -> None:
        if len(self.goal_ids) > 1:
            self.feed(self.goal_ids[1], 5.0)

    async def accept(self, request: Any, response: Any) -> Any:
        await super().accept(request, response)
        if len(self.goal_ids) == 1:
            await self.at_last
        self.answered += 1
        return response

    async def result(self, request: Any, response: Any) -> Any:
        if bytes(request.goal_id.uuid) != self.goal_ids[0]:
            await self.never
        return response  # its status is UNKNOWN


async def test_an_old_goal_that_is_accepted_late_is_cancelled() -> None:
    made: list[Sluggish] = []
    async with robot(making(made, Sluggish), offers="move_to_shelf") as it:
        assert not (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ABORTED)
        assert (await ended(go(it, 7))).ok
        before: Any = it.snapshot.goal
        begin(made[0], lambda: made[0].at_last.set_result(True))
        await until(lambda: made[0].answered == 2)
        await until(lambda: it.snapshot.goal and it.snapshot.goal.heard > before.heard)
        await until(lambda: made[0].cancelled == made[0].goal_ids[:1])  # else it would be driven
        goal: Any = it.snapshot.goal
        assert (goal.target, goal.phase, goal.started) == ("7", Phase.MOVING, before.started)
        assert [g.target for g in it.snapshot.history] == ["3"]


async def test_values_of_a_node_that_was_restarted_under_its_name_are_read_again() -> None:
    made: list[Any] = []

    def make(**options: Any) -> Node:
        made.append(Node("keeper", **options))
        made.append(guest(1))
        return made[0]  # type: ignore[no-any-return]

    def guest(number: int) -> Node:
        node = Node("guest", context=made[0].context)
        node.declare_parameter("number", number)
        return node

    async with robot(make, nodes=2) as it:
        begin(made[0], made[0].executor.add_node, made[1])
        await until(lambda: it.snapshot.parameter("number"))

        def restart() -> None:  # between two looks at the graph, with no word on parameter events
            made[1].destroy_node()
            again = Node("guest", context=made[0].context, parameter_overrides=[FIVE])
            again._parameter_events = None
            again.declare_parameter("number", 1)
            made[0].executor.add_node(again)
            made.append(again)

        begin(made[0], restart)
        await until(lambda: it.snapshot.parameter("number").value == 5)  # type: ignore[union-attr]
        made[2].destroy_node()


async def test_a_stop_waits_for_a_server_that_is_only_just_coming() -> None:
    made: list[Any] = []
    async with robot(making(made, quiet)) as it:
        asked = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: it.snapshot.open_stop is not None)
        late = stopping(EmergencyStop, yes)(context=made[0].context)
        begin(made[0], made[0].executor.add_node, late)
        assert (await ended(asked)).text == "confirmed"
        late.destroy_node()


async def test_a_stop_that_nobody_serves_says_what_is_missing_and_is_not_forgotten() -> None:
    async with robot(quiet) as it:
        before = clock.seconds()
        outcome = await ended(it.emergency_stop())
        assert outcome.text == ("/emergency_stop is not offered by any node: use the hardware stop")
        assert outcome.code == Code.NOT_OFFERED
        assert clock.seconds() - before >= 2.0
        assert it.snapshot.open_stop is not None
        events = [event.text for event in it.snapshot.events if event.level == "YOU"]
        assert events == [f"STOP: {outcome.text}"]
        released = await ended(it.release_emergency_stop())
        said = "no node has got the STOP, which is given up; nothing was sent"
        assert released == (Code.DONE, said)
        assert it.snapshot.open_stop is None


@pytest.mark.parametrize("kind", [SetBool, Empty])
async def test_a_stop_of_another_type_is_not_called_and_that_is_said_at_once(kind: Any) -> None:
    called: list[Any] = []

    def stop(request: Any, response: Any) -> Any:
        called.append(request)
        return response

    async with robot(stopping(kind, stop), offers="emergency_stop") as it:
        outcome = await ended(it.emergency_stop())
        assert not outcome.ok
        assert it.snapshot.open_stop is not None
        if kind is SetBool:  # called with a default, it would release
            assert called == []
            assert "std_srvs/srv/SetBool" in it.snapshot.faults["emergency_stop"]
            assert outcome.code == Code.REFUSED
            assert outcome.text == (
                "/emergency_stop is std_srvs/srv/SetBool, whose request differs: not called: "
                "use the hardware stop"
            )
        else:
            assert outcome.code == Code.NOT_CONFIRMED
            assert outcome.text == "answered, not confirmed: use the hardware stop"


@pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="one process cannot have both in Fast DDS, only two can"
)
async def test_a_client_of_another_type_does_not_hide_the_server() -> None:
    class Both(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("both", **options)
            self.create_client(Empty, "emergency_stop")
            self.create_service(EmergencyStop, "emergency_stop", self.stop)

        def stop(self, request: Any, response: Any) -> Any:
            response.success, response.message = True, "Stopped"
            return response

    async with robot(Both, offers="emergency_stop") as it:
        assert (await ended(it.emergency_stop())).text == "confirmed"


async def test_who_watches_sends_nothing_whoever_asks_for_it() -> None:
    heard: list[str] = []

    def refuse(_: Any) -> GoalResponse:
        heard.append("a goal")
        return GoalResponse.REJECT

    def stop(request: Any, response: Any) -> Any:
        heard.append("STOP")
        return response

    class Watched(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("watched", **options)
            self.action = ActionServer(
                self, MoveToShelf, "move_to_shelf", print, goal_callback=refuse
            )
            self.create_service(EmergencyStop, "emergency_stop", stop)

    async with robot(Watched, watch=True, offers="move_to_shelf emergency_stop") as it:
        for outcome in (await ended(go(it, 3)), await ended(it.emergency_stop())):
            assert outcome.code == Code.WATCHING
            assert outcome.text.startswith("watching only")
    assert heard == []


async def test_what_is_commanded_at_once_reaches_the_node_in_its_order() -> None:
    numbers: list[int] = []

    class Noting(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("noting", **options)
            self.declare_parameter("number", 0)
            self.add_post_set_parameters_callback(lambda given: numbers.append(given[0].value))

    async with robot(Noting) as it:
        await until(lambda: it.snapshot.parameter("number"))
        each = [it.set_parameters("/noting", {"number": n}) for n in range(1, 6)]
        assert all(outcome.ok for outcome in await ended(asyncio.gather(*each)))
    assert numbers == [1, 2, 3, 4, 5]
