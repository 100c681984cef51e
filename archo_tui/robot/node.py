"""The node of the console, which hands every message that it receives to the black box, too."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message

from archo_tui.robot.messages.types import element_of

# Gets the full name of a topic, the message class, and a message as CDR.
MessageCallback = Callable[[str, Any, bytes], None]


class Listener(Node):
    """A node that calls `on_message` with each message, before the callback of its subscription.

    Only subscriptions by `listen_quietly` do so.
    """

    def __init__(
        self,
        name: str,
        on_message: MessageCallback,
        masks: Mapping[Any, Callable[[Any], Any]],
        **options: Any,
    ) -> None:
        super().__init__(name, **options)
        self._on_message, self._masks = on_message, masks

    def listen_quietly(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: QoSProfile | int
    ) -> Any:
        """Subscribe to a topic; nothing is logged about an incompatible QoS.

        rclpy checks the event handlers that log at each wake-up.
        """
        name, mask = self.resolve_topic_name(topic), self._masks.get(kind)

        def on_data(data: bytes) -> None:
            message = deserialize_message(data, kind)
            shown = message if mask is None else mask(message)
            self._on_message(name, kind, data if shown is message else serialize(shown))
            callback(message)

        return self.listen_raw(kind, topic, on_data, qos)

    def listen_raw(
        self, kind: Any, topic: str, callback: Callable[[bytes], None], qos: QoSProfile | int
    ) -> Any:
        """Subscribe to a topic for messages as bytes, which `on_message` does not get."""
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        return self.create_subscription(kind, topic, callback, qos, event_callbacks=quiet, raw=True)

    def without_secrets(self, message: Any) -> Any:
        """Return a message as `on_message` would get it: with secret values masked. Any thread."""
        mask = self._masks.get(type(message))
        return message if mask is None else mask(message)


# The serialize_message of Jazzy returns as many bytes as it had estimated, the last of which are
# whatever lay in that memory. Readers refuse a message with more bytes than its fields have. Sizes
# and alignment are those of XCDR version 1, as OMG's DDS-XTypes 1.3 defines it in 7.4.

_PRIMITIVE_SIZES = {
    "boolean": 1, "octet": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2,
    "int32": 4, "uint32": 4, "float": 4, "int64": 8, "uint64": 8, "double": 8,
}  # fmt: skip
_ENCAPSULATION = 4  # Bytes of the header; offsets are counted from behind it.


def serialize(message: Any) -> bytes:
    """Return a message as CDR, and no more."""
    return serialize_message(message)[: cdr_size(message)]


def cdr_size(message: Any) -> int:
    """Return the number of bytes of a message as CDR, with the 4 of the encapsulation header."""
    return _ENCAPSULATION + _message_end(message, 0)


def _message_end(message: Any, offset: int) -> int:
    fields = message.get_fields_and_field_types()
    for name, kind in fields.items():
        offset = _field_end(kind, getattr(message, name), offset)
    return offset if fields else offset + 1  # rosidl gives an empty message a dummy byte.


def _field_end(kind: str, value: Any, offset: int) -> int:
    element = element_of(kind)
    if element is None:
        return _value_end(kind, value, offset)
    if kind.startswith("sequence<"):
        offset = _align(offset, 4) + 4  # Its length.
    size = _PRIMITIVE_SIZES.get(element)
    if size is not None:
        return _align(offset, size) + size * len(value) if len(value) else offset
    for item in value:
        offset = _value_end(element, item, offset)
    return offset


def _value_end(kind: str, value: Any, offset: int) -> int:
    if kind.partition("<")[0] == "string":
        return _align(offset, 4) + 4 + len(value.encode()) + 1
    if kind.partition("<")[0] == "wstring":
        return _align(offset, 4) + 4 + 2 * len(value.encode("utf-16-le"))  # Four bytes a code unit.
    if kind in _PRIMITIVE_SIZES:
        return _align(offset, _PRIMITIVE_SIZES[kind]) + _PRIMITIVE_SIZES[kind]
    return _message_end(value, offset)


def _align(offset: int, size: int) -> int:
    return offset + -offset % size
