"""A tug: ARCHO's trade, with no name, type or field of ARCHO's."""

from __future__ import annotations

from typing import Any

from depot_interfaces.action import Haul
from depot_interfaces.msg import CellState, DriveState
from depot_interfaces.srv import Halt, Plug, Zero
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.node import Node
from rclpy.task import Future

TRACK, STEP = 20.0, 2.0  # m


class Power(Node):
    """Its battery; `level` is what it says next."""

    def __init__(self, **options: Any) -> None:
        super().__init__("power", **options)
        self.declare_parameter("weak_below", 30.0)
        self.level, self.filling = 80.0, False
        self._publisher = self.create_publisher(CellState, "cell", 10)
        self.create_service(Plug, "plug", self._on_plug)
        self.create_timer(0.2, self._tell)

    def _tell(self) -> None:
        weak = self.level < self.get_parameter("weak_below").value
        verdict = "weak" if weak else "fine"
        said = CellState(level=self.level, potential=36.5, filling=self.filling, verdict=verdict)
        self._publisher.publish(said)

    def _on_plug(self, request: Any, response: Any) -> Any:
        self.filling = request.connected
        response.done = True
        return response


class Hauler(Node):
    """Its drive: 2 m every 0.1 s, to bays 1 .. 4."""

    def __init__(self, **options: Any) -> None:
        super().__init__("hauler", **options)
        self.declare_parameter("track", TRACK)
        self.turns, self.left, self.latched = 400, 0.0, False
        self._goal: Any = None
        self._end: Any = None
        self._publisher = self.create_publisher(DriveState, "wheels", 10)
        self.create_service(Zero, "zero_turns", self._on_zero)
        self.create_service(Halt, "halt", self._on_halt)
        self.create_service(Halt, "unhalt", self._on_unhalt)
        ActionServer(
            self,
            Haul,
            "haul",
            self._execute,
            goal_callback=self._on_goal,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        self.create_timer(0.1, self._drive)

    def _drive(self) -> None:
        moving = self._goal is not None
        said = DriveState(turns=self.turns, velocity=2.0 * moving, rolling=moving)
        said.latched = self.latched
        self._publisher.publish(said)
        if not moving:
            return
        if self.latched or self._goal.is_cancel_requested:
            self._end.set_result("halted" if self.latched else "called back")
            return
        self._goal.publish_feedback(Haul.Feedback(to_go=self.left))
        if self.left <= 0.0:
            self._end.set_result("at the bay")
        self.left -= STEP
        self.turns += 10

    def _on_goal(self, goal: Any) -> GoalResponse:
        if goal.bay <= 4 and not self.latched:
            return GoalResponse.ACCEPT
        self.get_logger().warning("No: latched" if self.latched else f"No: no bay {goal.bay}")
        return GoalResponse.REJECT

    async def _execute(self, goal: Any) -> Any:
        self._end = Future(executor=self.executor)
        self.left, self._goal = TRACK, goal
        words = await self._end
        self._goal = None
        if words == "at the bay":
            goal.succeed()
        elif words == "called back":
            goal.canceled()
        else:
            goal.abort()
        return Haul.Result(words=words)

    def _on_zero(self, request: Any, response: Any) -> Any:
        self.turns = 0
        response.done, response.note = True, "counted from zero"
        return response

    def _on_halt(self, request: Any, response: Any) -> Any:
        self.latched = response.halted = True
        return response

    def _on_unhalt(self, request: Any, response: Any) -> Any:
        self.latched, response.halted = False, True
        return response
