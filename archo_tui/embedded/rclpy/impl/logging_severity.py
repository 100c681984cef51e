"""The module `rclpy.impl.logging_severity`: the levels of a log line."""

from enum import IntEnum


class LoggingSeverity(IntEnum):
    """The severities of rcl_interfaces/Log."""

    UNSET = 0
    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50
