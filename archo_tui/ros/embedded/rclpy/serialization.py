"""The module `rclpy.serialization`: messages as CDR bytes, as a bag or a bridge holds them."""

from __future__ import annotations

from typing import Any, TypeVar

from rclpy._rclpy_pybind11 import RMWError
from rclpy.type_support import check_is_valid_msg_type

from archo_tui.ros.embedded.cdr import CdrError, decode, encode

MsgT = TypeVar("MsgT")


def serialize_message(message: Any) -> bytes:
    """Return a message as CDR bytes; raise AttributeError for anything but a message."""
    check_is_valid_msg_type(type(message))
    return encode(message)


def deserialize_message(serialized_message: bytes, message_type: type[MsgT]) -> MsgT:
    """Return the message that CDR bytes hold; bytes after it are ignored."""
    check_is_valid_msg_type(message_type)
    if not isinstance(serialized_message, bytes):
        raise TypeError(f"expected bytes, got {type(serialized_message)}")
    try:
        message: MsgT = decode(serialized_message, message_type)
    except CdrError as error:
        name = message_type.__name__
        raise RMWError(f"failed to deserialize ROS message {name}: {error}") from None
    return message
