"""`rclpy.logging`: loggers without a node."""

from __future__ import annotations

from rclpy import _logging
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.impl.rcutils_logger import RcutilsLogger

__all__ = ["LoggingSeverity", "get_logger", "get_logger_effective_level", "set_logger_level"]


def get_logger(name: str) -> RcutilsLogger:
    """A logger of that name. Raises ValueError for an empty one."""
    if not name:
        raise ValueError("Logger name must not be empty.")
    return RcutilsLogger(name)


def set_logger_level(name: str, level: LoggingSeverity | int) -> None:
    """Set a logger's level by name."""
    _logging.set_level(name, int(level))


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """The level in force for that name."""
    return LoggingSeverity(_logging.effective_level(name))
