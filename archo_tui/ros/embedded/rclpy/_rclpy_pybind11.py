"""The errors of rclpy's C layer, which programs know by the names they have there."""

from __future__ import annotations


class RCLError(RuntimeError):
    """The base of errors of rcl, and the error for an operation that rcl refuses."""


class InvalidHandle(RuntimeError):
    """The error for a use of an object that has been destroyed."""


class UnknownROSArgsError(RuntimeError):
    """The error for an argument behind `--ros-args` that ROS does not know."""


class RCLInvalidROSArgsError(RCLError):
    """The error for an argument behind `--ros-args`, or a file named there, that is not valid."""


class RMWError(RuntimeError):
    """The error of the middleware; here only for bytes that hold no message of the given type."""


class UnsupportedEventTypeError(RCLError):
    """The error for a callback of deadline or liveliness events, which do not exist here."""


class NodeNameNonExistentError(RCLError):
    """The error for a question about a node that is not on the graph."""


class TimerCancelledError(RCLError):
    """The error for a call of a canceled timer; this engine never raises it."""
