"""The node fake_battery_drain, which drains the battery fast, to see its warnings."""

from __future__ import annotations

from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float32

from archo_bringup.parameters import double


class FakeBatteryDrain(Node):
    """A node that publishes `battery_drain`, the percent to take off, once a second."""

    def __init__(self, **options: Any) -> None:
        super().__init__("fake_battery_drain", **options)
        self.declare_parameter("drain", *double(2.0, "% taken off each second", 0.0, 100.0))
        self.publisher = self.create_publisher(Float32, "battery_drain", 10)
        self.create_timer(1.0, self.on_timer)

    def on_timer(self) -> None:
        self.publisher.publish(Float32(data=self.get_parameter("drain").value))


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    try:
        rclpy.spin(FakeBatteryDrain())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
