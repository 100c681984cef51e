"""What programs know of rclpy's C layer, under the names it has there: its errors."""

from __future__ import annotations


class RCLError(RuntimeError):
    """The client library refused an operation."""


class InvalidHandle(RuntimeError):
    """The object behind this handle has been destroyed."""


class UnknownROSArgsError(RuntimeError):
    """An argument behind `--ros-args` that ROS does not know."""


class RCLInvalidROSArgsError(RCLError):
    """An argument behind `--ros-args` that cannot be read."""


class RMWError(RuntimeError):
    """The middleware refused an operation."""


class UnsupportedEventTypeError(RCLError):
    """The middleware does not tell of such events."""


class NodeNameNonExistentError(RCLError):
    """No node of that name is on the graph."""


class TimerCancelledError(RCLError):
    """A timer that was canceled meanwhile is called."""
