"""The node dashboard, which warns when the battery is low."""

from __future__ import annotations

from typing import Any

import rclpy
from archo_interfaces.msg import BatteryStatus
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

from archo_bringup import battery_model


class Dashboard(Node):
    """A node that subscribes to `battery_level` and logs what it receives."""

    def __init__(self, **options: Any) -> None:
        super().__init__("dashboard", enable_logger_service=True, **options)
        self.create_subscription(BatteryStatus, "battery_level", self.on_battery, 10)

    def on_battery(self, message: BatteryStatus) -> None:
        self.get_logger().info(f"Dashboard sees: {message.percentage:.1f}%")
        if message.battery_health != battery_model.GOOD:
            self.get_logger().warning(f"Low battery: {message.percentage:.1f}%")


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    try:
        rclpy.spin(Dashboard())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
