"""The module `rclpy.type_support`: checks of interface classes."""

from __future__ import annotations

from typing import Any


def check_for_type_support(msg_or_srv_type: Any) -> None:
    """Raise AttributeError unless a class is an interface."""
    if not (hasattr(msg_or_srv_type, "__type_name__") and isinstance(msg_or_srv_type, type)):
        said = "has no attribute '_TYPE_SUPPORT': it is no interface of ROS 2"
        raise AttributeError(f"{msg_or_srv_type!r} {said}")


def _check(kind: Any, what: str, *names: str) -> None:
    check_for_type_support(kind)
    if not all(hasattr(kind, name) for name in names):
        raise RuntimeError(f"The type provided is not valid: {kind} is no {what}")


def check_is_valid_msg_type(msg_type: Any) -> None:
    """Raise RuntimeError or AttributeError unless a class is a message."""
    _check(msg_type, "message", "get_fields_and_field_types")


def check_is_valid_srv_type(srv_type: Any) -> None:
    """Raise RuntimeError or AttributeError unless a class is a service."""
    _check(srv_type, "service", "Request", "Response")


def check_is_valid_action_type(action_type: Any) -> None:
    """Raise AttributeError unless a class is an action."""
    check_for_type_support(action_type)
    if not hasattr(action_type, "Impl"):
        raise AttributeError(f"{action_type!r} has no attribute 'Impl': it is no action")
