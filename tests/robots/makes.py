"""Robots of three makes as operators meet them: Nav2, a TurtleBot 4, a Create 3.

Their types are ROS's own; on the embedded engine those of tests/share.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
from irobot_create_msgs.action import Dock, DriveDistance, RotateAngle, Undock
from irobot_create_msgs.srv import EStop
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import Odometry
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future
from sensor_msgs.msg import BatteryState

STEP = 0.5  # m in each tenth of a second


class _Drives:
    """Serves actions that report how far it still is, 5 m at first; a stop aborts their goals."""

    is_stopped = False

    def serve(self, node: Any, kind: Any, name: str, left: str) -> None:
        ActionServer(
            node,
            kind,
            name,
            partial(self._execute, node, kind, left),
            goal_callback=lambda _: self.answer(),
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def answer(self) -> GoalResponse:
        return GoalResponse.ACCEPT

    async def _execute(self, node: Any, kind: Any, left: str, goal: Any) -> Any:
        ended: Any = Future(executor=node.executor)
        way = [5.0]

        def drive() -> None:
            if ended.done():
                return
            if left:
                goal.publish_feedback(kind.Feedback(**{left: way[0]}))
            way[0] -= STEP
            if goal.is_cancel_requested or way[0] < 0 or self.is_stopped:
                ended.set_result(None)

        timer = node.create_timer(0.1, drive)
        await ended
        node.destroy_timer(timer)
        if goal.is_cancel_requested:
            goal.canceled()
        elif self.is_stopped:
            goal.abort()
        else:
            goal.succeed()
        return kind.Result()


class Navigator(LifecycleNode, _Drives):
    """Nav2's bt_navigator: it takes goals while it is active."""

    def __init__(self, **options: Any) -> None:
        super().__init__("bt_navigator", **options)
        self._is_active = False
        self.serve(self, NavigateToPose, "navigate_to_pose", "distance_remaining")

    def answer(self) -> GoalResponse:
        return GoalResponse.ACCEPT if self._is_active else GoalResponse.REJECT

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


class Create3(Base, _Drives):
    """A Create 3: battery, docking, two moves, and an emergency stop."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._battery = self.create_publisher(BatteryState, "battery_state", 10)
        self.create_timer(0.5, self._publish_battery)
        self.create_service(EStop, "e_stop", self._on_stop)
        self.serve(self, Dock, "dock", "")
        self.serve(self, Undock, "undock", "")
        self.serve(self, DriveDistance, "drive_distance", "remaining_travel_distance")
        self.serve(self, RotateAngle, "rotate_angle", "remaining_angle_travel")

    def _publish_battery(self) -> None:
        self._battery.publish(BatteryState(percentage=0.8, voltage=15.6))

    def _on_stop(self, request: Any, response: Any) -> Any:
        self.is_stopped, response.success = request.e_stop_on, True
        return response


NAV2 = (Navigator, Localization, Base)
TURTLEBOT4 = (Navigator, Localization, Create3)
CREATE3 = (Create3,)
