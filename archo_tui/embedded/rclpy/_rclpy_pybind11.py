"""What programs know of rclpy's C layer, under the names it has there: errors, and profiles."""

from __future__ import annotations

from typing import Any


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


class rmw_qos_profile_t:  # its name in C
    """The policies of a profile as plain values."""

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values

    def to_dict(self) -> dict[str, Any]:
        """Policies by name: numbers, Durations and a bool."""
        return dict(self._values)

    @classmethod
    def predefined(cls, name: str) -> rmw_qos_profile_t:
        """`qos_profile_default` and so on. Raises ValueError for another name."""
        from rclpy import qos  # which needs this module

        profile = getattr(qos, name, None)
        if not isinstance(profile, qos.QoSProfile):
            raise ValueError(f"Requested unknown rmw_qos_profile: {name}")
        return profile.get_c_qos_profile()
