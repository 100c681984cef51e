"""A robot in the field, in ROS's own message types; on the embedded engine those of tests/share."""

from __future__ import annotations

import contextlib
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Empty, SetBool, Trigger


class Base(Node):
    """The base: battery in 0 to 1, motion, pose, diagnostics, a STOP, and two commands.

    `parts` holds level and message of each part, of another hardware than `sn 12` as
    `motor@left`; a part that is taken out is silent.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        self.is_stopped, self.lamp = False, False
        self._battery = self.create_publisher(
            BatteryState, "battery_state", qos_profile_sensor_data
        )
        self._odometry = self.create_publisher(Odometry, "odom", 10)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._pose = self.create_publisher(PoseWithCovarianceStamped, "amcl_pose", latched)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.parts = {"base: left motor": (DiagnosticStatus.OK, "fine")}
        self.create_timer(0.5, self._publish_diagnostics)
        self._publish_pose()
        self.get_logger().warning("the base was started")
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

    def _publish_pose(self) -> None:
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x, message.pose.pose.position.y = 1.2, 0.4
        message.pose.pose.orientation.z = message.pose.pose.orientation.w = 0.5**0.5
        self._pose.publish(message)

    def _publish_diagnostics(self) -> None:
        message = DiagnosticArray()
        message.status = [
            DiagnosticStatus(
                name=part.partition("@")[0],
                level=level,
                message=text,
                hardware_id=part.partition("@")[2] or "sn 12",
            )
            for part, (level, text) in self.parts.items()
        ]
        self._diagnostics.publish(message)

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
