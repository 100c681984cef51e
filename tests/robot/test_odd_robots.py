"""Robots that do what is allowed and rare."""

from __future__ import annotations

from typing import Any

from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future
from std_msgs.msg import Float32

from archo_tui.robot.state import Phase
from tests.console.states import goal
from tests.support import clock
from tests.support.archo import go
from tests.support.console import console, screen_text
from tests.support.quiet import Quiet, ended, until
from tests.support.robot import robot
from tests.support.stub import stub_app


class Unset(Node):
    """Has a parameter that was declared and never set, and one that is no number."""

    def __init__(self, **options: Any) -> None:
        super().__init__("unset", **options)
        self.declare_parameter("speed", 0.5)
        self.declare_parameter("later", Parameter.Type.DOUBLE)
        self.declare_parameter("odd", float("nan"))


async def test_a_parameter_without_a_value_hides_none_of_the_others() -> None:
    async with robot(Unset) as it:
        await until(lambda: it.snapshot.parameter("speed"))
        known = {p.name: p for p in it.snapshot.parameters}
        assert (known["speed"].value, known["later"].value) == (0.5, None)
        assert known["later"].type == "double"
        assert not known["odd"].is_changed
        assert (await ended(it.set_parameters("/unset", {"later": 1.5}))).ok
        await until(lambda: it.snapshot.parameter("later").value == 1.5)  # type: ignore[union-attr]


async def test_a_parameter_without_a_value_is_edited_from_an_empty_field() -> None:
    async with console(node_makers=[Unset], wait=False) as op:
        await op.until("later")
        assert "--" in op.line("later")
        assert "*" not in op.line("odd")
        await op.press("4", "slash", *"later", "enter")
        await op.at(clock.seconds() + 1.0)
        await op.press("enter", *"2.5", "enter")
        await op.until("2.5 *")


class Latched(Node):
    """Says its charge once, to whoever comes later, too."""

    def __init__(self, **options: Any) -> None:
        super().__init__("latched", **options)
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.battery = self.create_publisher(Float32, "battery_level", kept)
        self.battery.publish(Float32(data=42.0))


async def test_a_reading_that_was_latched_before_is_shown() -> None:
    async with robot(Latched) as it:
        await until(lambda: it.snapshot.battery.percentage == 42.0)


class LateTeller(Node):
    """Takes a goal, and gives its first feedback 8 s later."""

    def __init__(self, **options: Any) -> None:
        super().__init__("late_teller", **options)
        self.goal: Any = None
        self.over: Future[bool] = Future()
        self.began = 0.0
        self.action = ActionServer(
            self, MoveToShelf, "move_to_shelf", self.drive, cancel_callback=self.cancel
        )
        self.create_timer(0.5, self.tell)

    def cancel(self, _: Any) -> CancelResponse:
        self.over.set_result(True)
        return CancelResponse.ACCEPT

    def tell(self) -> None:
        if self.goal is not None and clock.seconds() - self.began > 8.0:
            self.goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=9.0))

    async def drive(self, goal: Any) -> MoveToShelf.Result:
        self.goal, self.began = goal, clock.seconds()
        await self.over
        self.goal = None
        goal.canceled()
        return MoveToShelf.Result()


async def test_an_action_whose_first_feedback_is_late_is_not_lost_before_it() -> None:
    phases: set[Any] = set()

    def looked(it: Any) -> bool:
        phases.add(it.snapshot.goal.phase)
        return bool(it.snapshot.goal.remaining == 9.0)

    async with robot(LateTeller) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.offered)
        assert (await ended(go(it, 3))).ok
        await until(lambda: looked(it))
        assert phases == {Phase.MOVING}
        assert (await ended(it.cancel())).ok


async def test_the_header_does_not_say_online_beside_a_goal_that_is_lost() -> None:
    app = stub_app(goal(Phase.LOST, heard=clock.NOW - 3.2))
    async with app.run_test(size=(120, 36)):
        await Quiet(app).settle()
        assert "● online" not in screen_text(app)
        assert "▲ move_to_shelf silent" in screen_text(app)
