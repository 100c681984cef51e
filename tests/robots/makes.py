"""Robots of three makes as operators meet them: Nav2, a TurtleBot 4, a Create 3.

Their types are ROS's own; on the embedded engine those of tests/share.
"""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from irobot_create_msgs.action import Dock, DriveDistance, RotateAngle, Undock
from irobot_create_msgs.srv import EStop
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import Odometry
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import BatteryState

from tests.support.stand_in import Drive


class Navigator(LifecycleNode):
    """Nav2's bt_navigator: it takes goals while it is active."""

    def __init__(self, **options: Any) -> None:
        super().__init__("bt_navigator", **options)
        self._is_active = False
        name, left = "navigate_to_pose", "distance_remaining"
        Drive(self, NavigateToPose, name, left, accepts=lambda _: self._is_active)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._is_active = True
        return super().on_activate(state)


class Localization(Node):
    """Nav2's amcl: the pose in the map, sent once and kept."""

    def __init__(self, **options: Any) -> None:
        super().__init__("amcl", **options)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._pose = self.create_publisher(PoseWithCovarianceStamped, "amcl_pose", latched)
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x = 1.2
        message.pose.pose.orientation.w = 1.0
        self._pose.publish(message)


class Base(Node):
    """Any base with odometry."""

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        self._odometry = self.create_publisher(Odometry, "odom", 10)
        self.create_timer(0.1, lambda: self._odometry.publish(Odometry()))


class Create3(Base):
    """A Create 3: battery, docking, two moves, and an emergency stop."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._battery = self.create_publisher(BatteryState, "battery_state", 10)
        self.create_timer(0.5, self._publish_battery)
        self.create_service(EStop, "e_stop", self._on_stop)
        self._drives = [
            Drive(self, Dock, "dock"),
            Drive(self, Undock, "undock"),
            Drive(self, DriveDistance, "drive_distance", "remaining_travel_distance"),
            Drive(self, RotateAngle, "rotate_angle", "remaining_angle_travel"),
        ]

    def _publish_battery(self) -> None:
        self._battery.publish(BatteryState(percentage=0.8, voltage=15.6))

    def _on_stop(self, request: Any, response: Any) -> Any:
        for drive in self._drives if request.e_stop_on else ():
            drive.end("abort")
        response.success = True
        return response


NAV2 = (Navigator, Localization, Base)
TURTLEBOT4 = (Navigator, Localization, Create3)
CREATE3 = (Create3,)
