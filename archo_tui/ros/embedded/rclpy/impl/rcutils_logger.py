"""The module `rclpy.impl.rcutils_logger`."""

from rclpy.logging import RcutilsLogger as RcutilsLogger
