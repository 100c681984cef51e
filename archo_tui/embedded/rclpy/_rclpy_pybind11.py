"""The errors of rclpy's C layer, which programs know by the names they have there."""

from __future__ import annotations


class RCLError(RuntimeError):
    """An operation that the client library refused."""


class InvalidHandle(RuntimeError):
    """A use of an object that has been destroyed."""


class UnknownROSArgsError(RuntimeError):
    """An argument behind `--ros-args` that ROS does not know."""


class RCLInvalidROSArgsError(RCLError):
    """An argument behind `--ros-args` that cannot be read."""


class RMWError(RuntimeError):
    """An operation that the middleware refused."""


class UnsupportedEventTypeError(RCLError):
    """A kind of event that the middleware does not tell of."""


class NodeNameNonExistentError(RCLError):
    """A node name that is not on the graph."""


class TimerCancelledError(RCLError):
    """A call of a timer that was canceled meanwhile."""
