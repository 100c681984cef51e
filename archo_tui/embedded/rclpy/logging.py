"""The module `rclpy.logging`: loggers without a node."""

from __future__ import annotations

import os
from pathlib import Path

from rclpy import _logging
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.impl.rcutils_logger import RcutilsLogger

__all__ = [
    "LoggingSeverity",
    "clear_config",
    "get_logger",
    "get_logger_effective_level",
    "get_logger_level",
    "get_logging_directory",
    "get_logging_severity_from_string",
    "set_logger_level",
]


_root_logger = RcutilsLogger()


def get_logger(name: str) -> RcutilsLogger:
    """Return a new logger of that name, without a node; raise ValueError for an empty name."""
    if not name:
        raise ValueError("Logger name must not be empty.")
    return _root_logger.get_child(name)


def set_logger_level(name: str, level: LoggingSeverity | int) -> None:
    """Set a logger's level by name, as `RcutilsLogger.set_level`; "" means the root."""
    _logging.set_level(name, LoggingSeverity(level))


def get_logger_level(name: str) -> LoggingSeverity:
    """Return the level that was set for that name itself; UNSET if the logger inherits one."""
    return LoggingSeverity(_logging.configured_level(name))


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Return the severity of a word such as `WARN`, in any case."""
    try:
        return LoggingSeverity[log_severity.upper()]
    except KeyError:
        raise RuntimeError("Failed to get severity name") from None


def clear_config() -> None:
    """Reset the root's level to INFO, and let every other logger inherit it."""
    _logging.forget_levels()


def get_logging_directory() -> Path:
    """Return where ROS keeps its logs: ROS_LOG_DIR, else `log` in ROS_HOME, else `~/.ros/log`.

    This engine writes nothing there.
    """
    home = Path(os.environ.get("ROS_HOME") or "~/.ros")
    found = Path(os.environ.get("ROS_LOG_DIR") or home / "log")
    if found.parts[0] == "~":
        if not os.environ.get("HOME"):
            raise RuntimeError("Failed to get current logging directory")
        found = Path(os.environ["HOME"], *found.parts[1:])
    return found


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """Return the level in force for that name, which may be inherited."""
    return LoggingSeverity(_logging.effective_level(name))
