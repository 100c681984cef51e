"""The module `rclpy.clock_type`."""

from enum import Enum


class ClockType(Enum):
    """The kinds of clock that ROS knows."""

    UNINITIALIZED = 0
    ROS_TIME = 1
    SYSTEM_TIME = 2
    STEADY_TIME = 3
