"""A cart whose stop ends the move and does not latch: the next goal drives at once."""

from __future__ import annotations

from typing import Any

from archo_interfaces.action import MoveToShelf
from archo_interfaces.srv import EmergencyStop
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

WAY, STEP = 100.0, 1.0  # m


class Cart(Node):
    """Drives 1 m every 0.1 s, wherever it is sent; `drives` is where to."""

    def __init__(self, **options: Any) -> None:
        super().__init__("cart", **options)
        self.drives = 0
        self.driven = 0  # goals so far
        self._left = 0.0
        self._goal: Any = None
        self._end: Any = None
        self._battery = self.create_publisher(Float32, "battery_level", 10)
        self.create_service(EmergencyStop, "emergency_stop", self._on_stop)
        self.create_service(Trigger, "blink", self._on_blink)
        ActionServer(
            self,
            MoveToShelf,
            "move_to_shelf",
            self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        self.create_timer(0.1, self._drive)

    def _drive(self) -> None:
        self._battery.publish(Float32(data=80.0))
        if self._goal is None or self._end.done():
            return
        if self._goal.is_cancel_requested:
            self._end.set_result("canceled")
            return
        self._goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=self._left))
        self._left -= STEP
        if self._left < 0.0:
            self._end.set_result("succeed")

    async def _execute(self, goal: Any) -> MoveToShelf.Result:
        self.drives, self.driven = goal.request.shelf_number, self.driven + 1
        self.get_logger().warning(f"drives to {self.drives}")
        self._end, self._left, self._goal = Future(executor=self.executor), WAY, goal
        how = await self._end
        self._goal, self.drives = None, 0
        getattr(goal, how)()
        self.get_logger().warning(f"stands: {how}")
        return MoveToShelf.Result(success=how == "succeed", final_message=how)

    def _on_stop(self, _: Any, response: EmergencyStop.Response) -> EmergencyStop.Response:
        if self._goal is not None and not self._end.done():
            self._end.set_result("abort")
        self.get_logger().warning("stopped once")
        response.success, response.message = True, "Stopped"
        return response

    def _on_blink(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        self.get_logger().warning("blinked")
        response.success = True
        return response
