"""A cart whose stop does not latch: it ends the goal that runs, and takes the next one."""

from __future__ import annotations

from typing import Any

from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float32
from std_srvs.srv import Trigger


class Cart(Node):
    """Drives until it is stopped or called back, and says whither."""

    def __init__(self, **options: Any) -> None:
        super().__init__("cart", **options)
        self._over: Any = None
        self._publisher = self.create_publisher(Float32, "battery_level", 10)
        self.create_service(Trigger, "emergency_stop", self._on_stop)
        ActionServer(
            self, MoveToShelf, "move_to_shelf", self._drive, cancel_callback=self._on_cancel
        )
        self.create_timer(0.2, lambda: self._publisher.publish(Float32(data=80.0)))

    def _on_stop(self, _: Any, response: Any) -> Any:
        if self._over is not None:
            self._over.set_result("stopped")
        response.success, response.message = True, "Stopped, not latched"
        return response

    def _on_cancel(self, _: Any) -> CancelResponse:
        self._over.set_result("called back")
        return CancelResponse.ACCEPT

    async def _drive(self, goal: Any) -> Any:
        self.get_logger().warning(f"driving to shelf {goal.request.shelf_number}")
        self._over = Future(executor=self.executor)
        how = await self._over
        self._over = None
        if how == "stopped":
            goal.abort()
        else:
            goal.canceled()
        return MoveToShelf.Result(final_message=how)
