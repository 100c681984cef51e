"""How many bytes a message takes as CDR.

The `serialize_message` of Jazzy hands out as many as it had estimated, the last of them being
whatever lay in that memory; readers count, and refuse what has more than its fields.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from archo_tui.robot.fields import element_of

_SIZES = {
    "boolean": 1, "octet": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2,
    "int32": 4, "uint32": 4, "float": 4, "int64": 8, "uint64": 8, "double": 8,
}  # fmt: skip
_ENCAPSULATION = 4  # bytes in front, which do not count for the places of what follows


class _Kind(NamedTuple):
    """A field's type."""

    base: str  # of one element, without a bound
    is_array: bool
    counted: bool  # a number of elements stands before them


def cdr_size(message: Any) -> int:
    """With the bytes in front that say how it is encoded."""
    return _ENCAPSULATION + _message(message, 0)


def _message(message: Any, place: int) -> int:
    """Where it ends that begins there."""
    fields = message.get_fields_and_field_types()
    for name, kind in fields.items():
        place = _field(_kind(kind), getattr(message, name), place)
    return place if fields else place + 1  # an empty structure is one byte


def _field(kind: _Kind, value: Any, place: int) -> int:
    if not kind.is_array:
        return _value(kind.base, value, place)
    if kind.counted:
        place = _aligned(place, 4) + 4
    size = _SIZES.get(kind.base)
    if size is not None:
        return _aligned(place, size) + size * len(value) if len(value) else place
    for item in value:
        place = _value(kind.base, item, place)
    return place


def _value(base: str, value: Any, place: int) -> int:
    if base == "string":
        return _aligned(place, 4) + 4 + len(value.encode()) + 1
    if base == "wstring":
        return _aligned(place, 4) + 4 + 2 * len(value.encode("utf-16-le"))  # four bytes a unit
    if base in _SIZES:
        return _aligned(place, _SIZES[base]) + _SIZES[base]
    return _message(value, place)


def _aligned(place: int, size: int) -> int:
    return place + -place % size


@cache
def _kind(text: str) -> _Kind:
    element = element_of(text)
    base = (element or text).partition("<")[0]  # of a bounded string
    return _Kind(base, element is not None, text.startswith("sequence<"))
