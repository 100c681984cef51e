"""A cart whose stop ends the move and does not latch: the next goal drives at once."""

from __future__ import annotations

from typing import Any

from archo_interfaces.action import MoveToShelf
from archo_interfaces.srv import EmergencyStop
from rclpy.node import Node
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

from tests.support.stand_in import Drive

WAY, STEP = 100.0, 1.0  # m


class Cart(Node):
    """Drives 1 m every 0.1 s, wherever it is sent."""

    def __init__(self, **options: Any) -> None:
        super().__init__("cart", **options)
        self.drive = Drive(
            self,
            MoveToShelf,
            "move_to_shelf",
            "distance_remaining",
            way=WAY,
            step=STEP,
            result=lambda how: {"success": how == "succeed", "final_message": how},
            told=self._tell,
        )
        self._battery = self.create_publisher(Float32, "battery_level", 10)
        self.create_service(EmergencyStop, "emergency_stop", self._on_stop)
        self.create_service(Trigger, "blink", self._on_blink)
        self.create_timer(0.1, lambda: self._battery.publish(Float32(data=80.0)))

    @property
    def driven(self) -> int:
        """Goals so far."""
        return len(self.drive.requests)

    @property
    def drives(self) -> bool:
        return self.drive.goal is not None

    def _tell(self, how: str) -> None:
        shelf = self.drive.requests[-1].shelf_number
        self.get_logger().warning(f"stands: {how}" if how else f"drives to {shelf}")

    def _on_stop(self, _: Any, response: EmergencyStop.Response) -> EmergencyStop.Response:
        self.drive.end("abort")
        self.get_logger().warning("stopped once")
        response.success, response.message = True, "Stopped"
        return response

    def _on_blink(self, _: Any, response: Trigger.Response) -> Trigger.Response:
        self.get_logger().warning("blinked")
        response.success = True
        return response
