"""The number of bytes that a message takes as CDR, the binary form in which DDS sends messages.

The `serialize_message` of Jazzy returns as many bytes as it had estimated, the last of which are
whatever lay in that memory. Readers refuse a message with more bytes than its fields have. Sizes
and alignment are those of XCDR version 1, as OMG's DDS-XTypes 1.3 defines it in 7.4.
"""

from __future__ import annotations

from typing import Any

from rclpy.serialization import serialize_message

from archo_tui.robot.messages.types import element_of

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
