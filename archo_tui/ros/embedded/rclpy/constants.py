"""The module `rclpy.constants`."""

from rclpy.duration import S_TO_NS as S_TO_NS
