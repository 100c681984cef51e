"""The module `rclpy.type_support`: checks of interface classes.

rclpy refuses other classes at once, and so does this engine.
"""

from __future__ import annotations

from typing import Any

from rclpy.exceptions import NoTypeSupportImportedException

_ROS_1 = (
    "This might be a ROS 1 message type but it should be a ROS 2 message type. "
    "Make sure to source your ROS 2 workspace after your ROS 1 workspace."
)


def check_for_type_support(msg_or_srv_type: Any) -> None:
    """Raise NoTypeSupportImportedException unless a class is an interface."""
    if hasattr(msg_or_srv_type, "__type_name__") and isinstance(msg_or_srv_type, type):
        return
    try:
        support = msg_or_srv_type._TYPE_SUPPORT
    except AttributeError as error:
        raise AttributeError(f"{error} {_ROS_1}") from None
    if support is None:
        msg_or_srv_type.__import_type_support__()
    if msg_or_srv_type._TYPE_SUPPORT is None:
        raise NoTypeSupportImportedException


def check_is_valid_msg_type(msg_type: Any) -> None:
    """Check that a class is a message."""
    check_for_type_support(msg_type)
    if not hasattr(msg_type, "get_fields_and_field_types"):
        raise RuntimeError(
            f"The message type provided is not valid ({msg_type}), "
            "this might be a service or action"
        )


def check_is_valid_srv_type(srv_type: Any) -> None:
    """Check that a class is a service."""
    check_for_type_support(srv_type)
    if not (hasattr(srv_type, "Request") and hasattr(srv_type, "Response")):
        raise RuntimeError(
            f"The service type provided is not valid ({srv_type}), "
            "this might be a message or action"
        )
