"""The conversion of messages to bytes and back: CDR, as OMG's DDS-XTypes 1.3 defines it in 7.4.

Bytes are written little-endian; big-endian is read too. A value stands at a multiple of its own
size (8 at most), counted behind the four bytes of the encapsulation header. Strings have their
length with a closing zero, sequences the number of elements.
"""

from __future__ import annotations

import struct
from typing import Any

from .idl import TYPE_CODES, FieldType

_LITTLE, _BIG = b"\x00\x01\x00\x00", b"\x00\x00\x00\x00"
_FORMATS = {**TYPE_CODES, "bool": "?", "byte": "c"}  # struct's are those of array, and more.


class CdrError(ValueError):
    """The error for bytes that are not a message of the expected type."""


def encode(message: Any) -> bytes:
    """Return a message as little-endian CDR bytes, with the encapsulation header.

    A list that was filled with wrong values is not checked again.
    """
    data = bytearray()
    _write_message(data, message)
    return _LITTLE + bytes(data)


def decode(data: bytes, message_class: Any) -> Any:
    """Return the message of a class that CDR bytes hold, little- or big-endian.

    Bytes after the message are ignored.
    """
    if data[:4] not in (_LITTLE, _BIG):
        raise CdrError("unknown encapsulation")
    try:
        return _Reader(data[4:], "<" if data[:4] == _LITTLE else ">").message(message_class)
    except (struct.error, UnicodeDecodeError, AssertionError, IndexError) as error:
        raise CdrError(str(error)) from None


def _write_message(data: bytearray, message: Any) -> None:
    if not message.__layout__:  # rosidl gives an empty message a dummy byte.
        data.append(0)
    for slot, kind, _ in message.__layout__:
        value = getattr(message, slot)
        if not kind.is_array:
            _write(data, kind, value)
            continue
        if kind.fixed_size is None:
            _write_number(data, "I", len(value))
        for item in value:
            _write(data, kind, item)


def _write(data: bytearray, kind: FieldType, value: Any) -> None:
    if kind.base == "string":
        text = value.encode() + b"\x00"
        _write_number(data, "I", len(text))
        data += text
    elif kind.base == "wstring":
        units = value.encode("utf-16-le")
        _write_number(data, "I", len(units) // 2)
        for place in range(0, len(units), 2):  # Fast DDS takes four bytes a character.
            _write_number(data, "I", int.from_bytes(units[place : place + 2], "little"))
    elif kind.base in _FORMATS:
        _write_number(data, _FORMATS[kind.base], value)
    else:
        _write_message(data, value)


def _write_number(data: bytearray, form: str, value: Any) -> None:
    size = struct.calcsize(f"<{form}")
    data += bytes(-len(data) % size)
    data += struct.pack(f"<{form}", value)


class _Reader:
    def __init__(self, data: bytes, order: str) -> None:
        self._data, self._order, self._place = data, order, 0

    def message(self, message_class: Any) -> Any:
        values = {}
        if not message_class.__layout__:
            self._number("B")
        for slot, kind, nested in message_class.__layout__:
            if not kind.is_array:
                values[slot[1:]] = self._value(kind, nested)
                continue
            count = self._number("I") if kind.fixed_size is None else kind.fixed_size
            if count > len(self._data):
                raise CdrError(f"a sequence of {count} elements in {len(self._data)} bytes")
            values[slot[1:]] = [self._value(kind, nested) for _ in range(count)]
        return message_class(**values)

    def _value(self, kind: FieldType, nested: Any) -> Any:
        if nested is not None:
            return self.message(nested)
        if kind.base == "string":
            return self._bytes(self._number("I"))[:-1].decode()
        if kind.base == "wstring":
            units = [self._number("I") for _ in range(self._number("I"))]
            return b"".join(unit.to_bytes(2, "little") for unit in units).decode("utf-16-le")
        return self._number(_FORMATS[kind.base])

    def _number(self, form: str) -> Any:
        size = struct.calcsize(f"<{form}")
        self._place += -self._place % size
        return struct.unpack(self._order + form, self._bytes(size))[0]

    def _bytes(self, count: int) -> bytes:
        found = self._data[self._place : self._place + count]
        if len(found) < count:
            raise CdrError(f"{len(self._data)} bytes are too few")
        self._place += count
        return found
