"""A robot in the field, in ROS's own message types: BatteryState, Odometry, Trigger, SetBool, ...

Real ROS 2 only: the embedded engine has no sensor_msgs.
"""

from __future__ import annotations

import contextlib
from typing import Any

import rclpy
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Empty, SetBool, Trigger


class Base(Node):
    """The base: its battery in 0 to 1, its motion, a STOP, and three commands."""

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        self.is_stopped, self.lamp = False, False
        self._battery = self.create_publisher(
            BatteryState, "battery_state", qos_profile_sensor_data
        )
        self._odometry = self.create_publisher(Odometry, "odom", 10)
        self.create_timer(0.5, self._publish_battery)
        self.create_timer(0.1, self._publish_odometry)
        self.create_service(Trigger, "emergency_stop", self._on_stop)
        self.create_service(Trigger, "reset_emergency_stop", self._on_release)
        self.create_service(SetBool, "lamp", self._on_lamp)
        self.create_service(Empty, "beep", lambda _, response: response)

    def _publish_battery(self) -> None:
        status = BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
        self._battery.publish(
            BatteryState(percentage=0.75, voltage=24.5, power_supply_status=status)
        )

    def _publish_odometry(self) -> None:
        self._odometry.publish(Odometry())

    def _on_stop(self, request: Any, response: Any) -> Any:
        self.is_stopped = response.success = True
        return response

    def _on_release(self, request: Any, response: Any) -> Any:
        self.is_stopped, response.success = False, True
        return response

    def _on_lamp(self, request: Any, response: Any) -> Any:
        self.lamp = request.data
        response.success, response.message = True, "on" if request.data else "off"
        return response


def main() -> None:
    """Run the robot."""
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Base())


if __name__ == "__main__":
    main()
