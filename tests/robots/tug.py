"""A tug: ARCHO's trade, with no name, type or field of ARCHO's."""

from __future__ import annotations

from typing import Any

from depot_interfaces.action import Haul
from depot_interfaces.msg import CellState, DriveState
from depot_interfaces.srv import Halt, Plug, Zero
from rclpy.node import Node

from tests.support.stand_in import Drive

TRACK = 20.0  # m


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
        self.turns, self.latched = 400, False
        words = {"succeed": "at the bay", "canceled": "called back", "abort": "halted"}
        self.drive = Drive(
            self,
            Haul,
            "haul",
            "to_go",
            way=TRACK,
            step=2.0,
            accepts=self._accepts,
            result=lambda how: {"words": words[how]},
        )
        self._publisher = self.create_publisher(DriveState, "wheels", 10)
        self.create_service(Zero, "zero_turns", self._on_zero)
        self.create_service(Halt, "halt", self._on_halt)
        self.create_service(Halt, "unhalt", self._on_unhalt)
        self.create_timer(0.1, self._tell)

    def _tell(self) -> None:
        moving = self.drive.goal is not None
        said = DriveState(turns=self.turns, velocity=2.0 * moving, rolling=moving)
        said.latched = self.latched
        self._publisher.publish(said)
        self.turns += 10 * moving

    def _accepts(self, goal: Any) -> bool:
        is_refused = self.latched or goal.bay > 4
        if is_refused:
            self.get_logger().warning("No: latched" if self.latched else f"No: no bay {goal.bay}")
        return not is_refused

    def _on_zero(self, request: Any, response: Any) -> Any:
        self.turns = 0
        response.done, response.note = True, "counted from zero"
        return response

    def _on_halt(self, request: Any, response: Any) -> Any:
        self.latched = response.halted = True
        self.drive.end("abort")
        return response

    def _on_unhalt(self, request: Any, response: Any) -> Any:
        self.latched, response.halted = False, True
        return response
