"""The module `rclpy.impl.logging_severity`."""

from rclpy.logging import LoggingSeverity as LoggingSeverity
