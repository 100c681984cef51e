"""Robot's verbs all end: done, refused with the reason, or no answer. No screen here."""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from archo_interfaces.action import MoveToShelf
from archo_interfaces.srv import EmergencyStop, ResetEncoder
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from std_msgs.msg import Float32
from std_srvs.srv import Empty, SetBool

from archo_tui.robot import calls
from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.goal import Phase
from archo_tui.text.goal import goal_line
from archo_tui.text.state import plain_text
from tests.support import chosen, clock
from tests.support.archo import SHELF, go, reset
from tests.support.quiet import ended, until
from tests.support.robot import robot

FIVE: Parameter[int] = Parameter("number", value=5)


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


def slow_server() -> Any:
    """A node with the action, whose goals never end by themselves."""

    class Slow(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("slow", **options)
            self.action = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)
            self.goals: list[Any] = []
            self.create_timer(0.5, self.report)

        def report(self) -> None:
            for goal in self.goals:
                goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=9.0))

        async def execute(self, goal: Any) -> Any:
            self.goals.append(goal)
            await Future()

    return Slow


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
    async with robot(server()) as it:
        await until(lambda: "reset_encoder" in it.snapshot.offered)
        outcome = await ended(reset(it))
        assert outcome == (Code.REFUSED, "the encoder is stuck")


async def test_a_server_that_hangs_gives_no_answer_and_the_next_call_works() -> None:
    hang = threading.Event()
    async with robot(server(hang=hang)) as it:
        await until(lambda: "reset_encoder" in it.snapshot.offered)
        outcome = await ended(reset(it))
        assert outcome.code == Code.TIMEOUT
        assert outcome.text.startswith("no answer in ")
        hang.set()
        assert (await ended(reset(it))).text == "the encoder is stuck"


async def test_a_server_that_nobody_spins_gives_no_answer() -> None:
    unspun: list[Node] = []

    def make(**options: Any) -> Node:
        unspun.append(server()(**options))
        return quiet(**options)

    async with robot(make, nodes=2) as it:
        await until(lambda: {"reset_encoder", "move_to_shelf"} <= it.snapshot.offered)
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

    async with robot(make, nodes=2) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        await ended(go(it, 3))
        made[0].action.destroy()  # rclpy leaves it on the graph when its node is destroyed
        made[0].destroy_node()
        reborn = server()(context=made[1].context)
        executor = made[1].executor
        assert executor is not None
        executor.create_task(executor.add_node, reborn)
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ABORTED)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message.startswith("the robot does not know this goal")
        reborn.destroy_node()


async def test_a_goal_without_an_answer_is_unknown_until_the_robot_says_more() -> None:
    hang = threading.Event()
    async with robot(server(hang=hang)) as it:
        await until(lambda: "reset_encoder" in it.snapshot.offered)
        await ended(reset(it))  # the server hangs in this one, and has not seen the goal
        outcome = await ended(go(it, 3))
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
        assert (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == phase)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message == "that was it"
        assert [goal.target for goal in it.snapshot.history] == ["3"]
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
        assert (await ended(go(it, 3))).ok
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
        assert outcome == (Code.DONE, "number is 2, was 1")
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
        "archo_tui.robot.readings.subscriptions.load_class",
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


async def test_a_stop_without_an_answer_is_not_forgotten() -> None:
    class Mute(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("mute", **options)
            self.create_service(EmergencyStop, "emergency_stop", self.hang)

        def hang(self, request: Any, response: Any) -> Any:
            with clock.stuck():
                release.wait(30)
            response.success = True
            return response

    release = threading.Event()
    async with robot(Mute) as it:
        await until(lambda: "emergency_stop" in it.snapshot.offered)
        outcome = await ended(it.emergency_stop())
        assert outcome.text == "no answer in 2 s: use the hardware stop"
        stop = it.snapshot.open_stop
        assert stop is not None
        await until(lambda: clock.seconds() > stop.asked + 6.0)
        assert it.snapshot.open_stop == stop
        release.set()


@pytest.mark.waits
async def test_a_cancelled_goal_may_be_silent_while_the_robot_brakes_and_then_is_lost() -> None:
    class Halting(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("halting", **options)
            accept = lambda _: CancelResponse.ACCEPT  # noqa: E731
            self.action = ActionServer(
                self, MoveToShelf, "move_to_shelf", self.execute, cancel_callback=accept
            )

        async def execute(self, goal: Any) -> Any:
            await Future()
            return MoveToShelf.Result()

    async with robot(Halting) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it, 3))).ok
        assert (await ended(it.cancel())).ok
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.phase == Phase.CANCELLING
        began = clock.seconds()
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.LOST)
        assert 13.0 < clock.seconds() - began < 19.0
        refused = await ended(go(it, 4))
        assert not refused.ok
        assert refused.text.startswith("nothing is heard of the goal to shelf 3: cancel it")


@pytest.mark.waits
async def test_a_goal_that_was_lost_is_followed_again_when_it_is_heard() -> None:
    class Slow(Node):
        """Says where it is each second, and says nothing for 10 s in between."""

        def __init__(self, **options: Any) -> None:
            super().__init__("slow", **options)
            self.action = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)
            self.left = 90.0
            self.goals: list[Any] = []
            self.create_timer(1.0, self.report)

        async def execute(self, goal: Any) -> Any:
            self.goals.append(goal)
            await Future()
            return MoveToShelf.Result()

        def report(self) -> None:
            self.left -= 1.0
            for goal in self.goals if self.left % 15 >= 10 else ():
                goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=self.left))

    async with robot(Slow) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it, 3))).ok
        for _ in range(2):
            await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.LOST)
            before: Any = it.snapshot.goal
            await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.MOVING)
            assert it.snapshot.goal is not None
            assert it.snapshot.goal.remaining != before.remaining


class Sluggish(Node):
    """Answers the first goal only at last, and knows nothing of it meanwhile; the next at once."""

    def __init__(self, **options: Any) -> None:
        super().__init__("sluggish", **options)
        self.asked: list[bytes] = []
        self.cancelled: list[bytes] = []
        self.at_last: Future[bool] = Future()
        self.never: Future[bool] = Future()
        self.answered = 0
        impl: Any = MoveToShelf.Impl
        self.impl, prefix = impl, "move_to_shelf/_action"
        group = ReentrantCallbackGroup()
        for kind, name, answer in (
            (impl.SendGoalService, "send_goal", self.accept),
            (impl.GetResultService, "get_result", self.result),
            (impl.CancelGoalService, "cancel_goal", self.cancel),
        ):
            self.create_service(kind, f"{prefix}/{name}", answer, callback_group=group)
        self.feedback = self.create_publisher(impl.FeedbackMessage, f"{prefix}/feedback", 10)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_publisher(impl.GoalStatusMessage, f"{prefix}/status", latched)
        self.create_timer(0.2, self.tell)

    async def accept(self, request: Any, response: Any) -> Any:
        self.asked.append(bytes(request.goal_id.uuid))
        if len(self.asked) == 1:
            await self.at_last
        self.answered += 1
        response.accepted = True
        return response

    async def result(self, request: Any, response: Any) -> Any:
        if bytes(request.goal_id.uuid) != self.asked[0]:
            await self.never
        return response  # its status is UNKNOWN

    async def cancel(self, request: Any, response: Any) -> Any:
        self.cancelled.append(bytes(request.goal_info.goal_id.uuid))
        return response

    def tell(self) -> None:
        if len(self.asked) > 1:
            message = self.impl.FeedbackMessage()
            message.goal_id.uuid = list(self.asked[1])
            message.feedback.distance_remaining = 5.0
            self.feedback.publish(message)


async def test_an_old_goal_that_is_accepted_late_is_cancelled() -> None:
    made: list[Sluggish] = []

    def make(**options: Any) -> Node:
        made.append(Sluggish(**options))
        return made[0]

    async with robot(make) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert not (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ABORTED)
        assert (await ended(go(it, 7))).ok
        before: Any = it.snapshot.goal
        assert made[0].executor is not None
        made[0].executor.create_task(lambda: made[0].at_last.set_result(True))
        await until(lambda: made[0].answered == 2)
        await until(lambda: it.snapshot.goal and it.snapshot.goal.heard > before.heard)
        await until(lambda: made[0].cancelled == made[0].asked[:1])  # else it would be driven
        goal: Any = it.snapshot.goal
        assert (goal.target, goal.phase, goal.started) == ("7", Phase.MOVING, before.started)
        assert [g.target for g in it.snapshot.history] == ["3"]


async def test_values_of_a_node_that_was_restarted_under_its_name_are_read_again() -> None:
    made: list[Node] = []

    def make(**options: Any) -> Node:
        made.append(Node("keeper", **options))
        made.append(guest(1))
        return made[0]

    def guest(number: int) -> Node:
        node = Node("guest", context=made[0].context)
        node.declare_parameter("number", number)
        return node

    async with robot(make, nodes=2) as it:
        executor = made[0].executor
        assert executor is not None
        executor.create_task(executor.add_node, made[1])
        await until(lambda: it.snapshot.parameter("number"))

        def restart() -> None:  # between two looks at the graph, with no word on parameter events
            made[1].destroy_node()
            again = Node("guest", context=made[0].context, parameter_overrides=[FIVE])
            again._parameter_events = None
            again.declare_parameter("number", 1)
            executor.add_node(again)
            made.append(again)

        executor.create_task(restart)
        await until(lambda: it.snapshot.parameter("number").value == 5)  # type: ignore[union-attr]
        made[2].destroy_node()


async def test_a_battery_that_is_published_with_best_effort_is_heard() -> None:
    class Radio(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("radio", **options)
            quality = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
            publisher = self.create_publisher(Float32, "battery_level", quality)
            self.create_timer(0.05, lambda: publisher.publish(Float32(data=44.5)))

    async with robot(Radio) as it:
        await until(lambda: it.snapshot.battery.percentage == 44.5)


@pytest.mark.waits
async def test_of_requests_that_nobody_answers_the_last_ones_are_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(calls, "MOST_UNANSWERED", 1)
    made: list[Node] = []

    def make(**options: Any) -> Node:
        made.append(server()(**options))  # nobody spins it
        made.append(quiet(**options))
        return made[1]

    async with robot(make, nodes=2) as it:
        await until(lambda: "reset_encoder" in it.snapshot.offered)
        for _ in range(3):
            assert not (await ended(reset(it))).ok
        client = it.services.client(ResetEncoder, "reset_encoder")
        assert len(client._pending_requests) == 1
        made[0].destroy_node()


class Stoppable(Node):
    """Hears STOP and goals; answers to each only when it is told to."""

    def __init__(self, **options: Any) -> None:
        super().__init__("stoppable", **options)
        self.group = ReentrantCallbackGroup()
        self.stop_answer: Future[bool] = Future()
        self.goal_answer: Future[bool] = Future()
        self.goals_seen = 0
        self.create_service(EmergencyStop, "emergency_stop", self.stop, callback_group=self.group)
        self.create_timer(0.05, lambda: None)  # an awaited future is noticed when something wakes
        self.action = ActionServer(
            self,
            MoveToShelf,
            "move_to_shelf",
            self.execute,
            goal_callback=self.on_goal,
            callback_group=self.group,
        )

    async def stop(self, request: Any, response: Any) -> Any:
        response.success = await self.stop_answer
        return response

    async def on_goal(self, request: Any) -> GoalResponse:
        self.goals_seen += 1
        await self.goal_answer
        return GoalResponse.ACCEPT

    async def execute(self, goal: Any) -> Any:
        await Future()

    def answer(self, future: Future[bool]) -> None:
        executor = self.executor
        assert executor is not None
        executor.create_task(lambda: future.set_result(True))


@asynccontextmanager
async def stoppable() -> AsyncIterator[tuple[Robot, Stoppable]]:
    made: list[Stoppable] = []

    def make(**options: Any) -> Node:
        made.append(Stoppable(**options))
        return made[0]

    async with robot(make) as it:
        await until(lambda: {"emergency_stop", "move_to_shelf"} <= it.snapshot.offered)
        yield it, made[0]


async def test_a_goal_from_before_a_stop_does_not_confirm_it() -> None:
    async with stoppable() as (it, node):
        going = asyncio.ensure_future(go(it, 3))
        await until(lambda: node.goals_seen)
        assert not (await ended(it.emergency_stop())).ok
        node.answer(node.goal_answer)
        await ended(going)
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.MOVING)
        assert it.snapshot.open_stop is not None


async def test_a_queued_goal_is_not_sent_behind_a_stop_that_nobody_answered() -> None:
    async with stoppable() as (it, node):
        assert not (await ended(it.emergency_stop())).ok
        outcome = await ended(it.send(SHELF, {"shelf_number": 3}, queued=True))
        assert outcome == (Code.HELD, "held: STOP")
        assert it.snapshot.goal is None
        assert node.goals_seen == 0


async def test_a_stop_waits_for_a_server_that_is_only_just_coming() -> None:
    made: list[Node] = []

    def make(**options: Any) -> Node:
        made.append(quiet(**options))
        return made[0]

    class Stop(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("stop", **options)
            self.create_service(EmergencyStop, "emergency_stop", self.stop)

        def stop(self, request: Any, response: Any) -> Any:
            response.success, response.message = True, "Stopped"
            return response

    async with robot(make) as it:
        stopping = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: it.snapshot.open_stop is not None)
        executor = made[0].executor
        assert executor is not None
        late = Stop(context=made[0].context)
        executor.create_task(executor.add_node, late)
        assert (await ended(stopping)).text == "confirmed"
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


@pytest.mark.parametrize(
    ("end", "success", "said"),
    [
        ("succeed", False, "the action says succeeded, its result says not"),
        ("abort", True, "the action says aborted, its result says success"),
    ],
)
async def test_a_status_and_a_result_that_disagree_are_not_called_an_arrival(
    end: str, success: bool, said: str
) -> None:
    class Confused(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("confused", **options)
            self.action = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)

        def execute(self, goal: Any) -> Any:
            getattr(goal, end)()
            return MoveToShelf.Result(success=success)

    async with robot(Confused) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        await ended(go(it, 3))
        await until(lambda: it.snapshot.goal and not it.snapshot.goal.is_running)
        goal: Any = it.snapshot.goal
        assert (goal.phase, goal.message) == (Phase.DISPUTED, said)
        await until(lambda: any(said in e.text for e in it.snapshot.events if e.level == "GOAL"))


async def test_an_end_without_words_says_that_there_are_none() -> None:
    class Terse(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("terse", **options)
            self.action = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)

        def execute(self, goal: Any) -> Any:
            goal.abort()
            return MoveToShelf.Result()

    async with robot(Terse) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        await ended(go(it, 3))
        await until(lambda: it.snapshot.goal and it.snapshot.goal.phase == Phase.ABORTED)
        assert it.snapshot.goal is not None
        assert it.snapshot.goal.message == "the robot gave no reason"


async def test_feedback_that_is_no_distance_is_shown_as_received_and_moves_nothing() -> None:
    class Odd(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("odd", **options)
            self.left = [9.0, math.nan, math.inf, -math.inf, -5.0]
            self.goal: Any = None
            self.action = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)

        async def execute(self, goal: Any) -> Any:
            self.goal = goal
            await Future()

        def report(self) -> None:
            left = MoveToShelf.Feedback(distance_remaining=self.left.pop(0))
            self.goal.publish_feedback(left)

    made: list[Odd] = []

    def make(**options: Any) -> Node:
        made.append(Odd(**options))
        return made[0]

    async with robot(make) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        await ended(go(it, 3))
        await until(lambda: made[0].goal)
        for said in ("", "nan", "inf", "-inf", "-5"):
            executor = made[0].executor
            assert executor is not None
            executor.create_task(made[0].report)
            await until(
                lambda said=said: (  # type: ignore[misc]
                    it.snapshot.goal
                    and it.snapshot.goal.remaining == 9.0
                    and it.snapshot.goal.unreadable == said
                )
            )
            text = plain_text(goal_line(it.snapshot, clock.seconds(), ""))
            assert (f"? {said} m left" in text) == bool(said)


@pytest.mark.parametrize("kind", [SetBool, Empty])
async def test_a_stop_of_another_type_is_not_called_and_that_is_said_at_once(kind: Any) -> None:
    called: list[Any] = []

    class Other(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("other", **options)
            self.create_service(kind, "emergency_stop", self.stop)

        def stop(self, request: Any, response: Any) -> Any:
            called.append(request)
            return response

    async with robot(Other) as it:
        await until(lambda: "emergency_stop" in it.snapshot.offered)
        outcome = await ended(it.emergency_stop())
        assert not outcome.ok
        assert it.snapshot.open_stop is not None
        if kind is SetBool:  # called with a default, it would release
            assert called == []
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

    async with robot(Both) as it:
        await until(lambda: "emergency_stop" in it.snapshot.offered)
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

    async with robot(Watched, watch=True) as it:
        await until(lambda: {"move_to_shelf", "emergency_stop"} <= set(it.snapshot.offered))
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
