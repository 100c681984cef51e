"""What may be assigned to a field of a message, and how its value is copied.

The checks are those of rosidl's Python classes (AssertionError, bool is an int, an int is not a
float), always on. Copies behave like a trip over the wire: nothing is shared, float32 is rounded.
"""

from __future__ import annotations

import array
import math
import struct
from collections.abc import Callable, Iterable
from typing import Any

from .idl import FLOATS, INTEGERS, FieldType

# element types that rosidl keeps in array.array, with array's type codes
TYPE_CODES = {
    "int8": "b", "uint8": "B", "char": "B", "int16": "h", "uint16": "H", "int32": "i",
    "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip

FLOAT32_MAX = 3.402823466e38
_FLOAT32 = struct.Struct("f")

Check = Callable[[Any], Any]
Copy = Callable[[Any], Any]


def round_to_float32(value: float) -> float:
    """The nearest value that four bytes can carry, as a receiver would read it."""
    result: float = _FLOAT32.unpack(_FLOAT32.pack(value))[0]
    return result


def scalar_check(name: str, base: str, bound: int | None, message_class: type | None) -> Check:
    """A function that returns its argument when one value of type `base` may be assigned."""
    if message_class is not None:
        said = f"a sub message of type '{message_class.__name__}'"
        return _instance_check(name, message_class, said)
    if base in INTEGERS:
        return _integer_check(name, *INTEGERS[base])
    if base == "float32":
        return _float32_check(name)
    if base == "float64":
        return _instance_check(name, float, "of type 'float'")
    if base == "bool":
        return _instance_check(name, bool, "of type 'bool'")
    if base == "byte":
        return _byte_check(name)
    return _string_check(name, bound)


def array_check(name: str, kind: FieldType, element: Check) -> Check:
    """Like `scalar_check` for arrays; returns what the message keeps (array.array or list)."""
    code = TYPE_CODES.get(kind.base)
    said = f"a set or sequence and each value of type '{_python_type(kind.base)}'"

    def check(value: Any) -> Any:
        if (isinstance(value, (str, bytes)) and kind.base != "uint8") or not isinstance(
            value, Iterable
        ):
            raise AssertionError(f"The '{name}' field must be {said}")
        if isinstance(value, array.array) and value.typecode == code:
            kept: Any = value
        else:
            try:
                items = [element(item) for item in value]
            except AssertionError:
                raise AssertionError(f"The '{name}' field must be {said}") from None
            kept = array.array(code, items) if code else items
        if kind.fixed_size is not None and len(kept) != kind.fixed_size:
            raise AssertionError(f"The '{name}' field must have {kind.fixed_size} elements")
        if kind.upper_bound is not None and len(kept) > kind.upper_bound:
            raise AssertionError(f"The '{name}' field must have <= {kind.upper_bound} elements")
        return kept

    return check


def _python_type(base: str) -> str:
    if base in INTEGERS:
        return "int"
    if base in FLOATS:
        return "float"
    return {"string": "str", "wstring": "str", "byte": "bytes"}.get(base, base.rpartition("/")[2])


def copier(kind: FieldType, check: Check, message_class: Any) -> Copy | None:
    """How to copy a field's value; None when the value can be handed over as it is."""
    if kind.is_array:
        if kind.base in TYPE_CODES:
            return lambda value: value[:]
        if message_class is not None:
            return lambda value: [item.__received__() for item in check(value)]
        return check  # lists can be changed in place, so they are checked again
    if message_class is not None:
        return message_class.__received__  # type: ignore[no-any-return]
    return round_to_float32 if kind.base == "float32" else None


def default_of(kind: FieldType, message_class: Any) -> Any:
    """The value of a field that nobody has set: zero, empty, false."""

    def one() -> Any:
        if message_class is not None:
            return message_class()
        if kind.base in FLOATS:
            return 0.0
        if kind.base in INTEGERS:
            return 0
        return {"bool": False, "byte": b"\x00"}.get(kind.base, "")

    return [one() for _ in range(kind.fixed_size or 0)] if kind.is_array else one()


def _instance_check(name: str, wanted: type, said: str) -> Check:
    def check(value: Any) -> Any:
        if not isinstance(value, wanted):
            raise AssertionError(f"The '{name}' field must be {said}")
        return value

    return check


def _integer_check(name: str, low: int, high: int) -> Check:
    def check(value: Any) -> Any:
        if not isinstance(value, int):
            raise AssertionError(f"The '{name}' field must be of type 'int'")
        if not low <= value <= high:
            sign = "an" if low < 0 else "an unsigned"
            raise AssertionError(f"The '{name}' field must be {sign} integer in [{low}, {high}]")
        return value

    return check


def _float32_check(name: str) -> Check:
    def check(value: Any) -> Any:
        if not isinstance(value, float):
            raise AssertionError(f"The '{name}' field must be of type 'float'")
        if abs(value) > FLOAT32_MAX and not math.isinf(value):
            limits = f"[-{FLOAT32_MAX}, {FLOAT32_MAX}]"
            raise AssertionError(f"The '{name}' field must be a float in {limits}")
        return value

    return check


def _byte_check(name: str) -> Check:
    def check(value: Any) -> Any:
        if not isinstance(value, bytes) or len(value) != 1:
            said = "of type 'bytes' or 'ByteString' with length 1"
            raise AssertionError(f"The '{name}' field must be {said}")
        return value

    return check


def _string_check(name: str, bound: int | None) -> Check:
    def check(value: Any) -> Any:
        if not isinstance(value, str):
            raise AssertionError(f"The '{name}' field must be of type 'str'")
        if bound is not None and len(value) > bound:
            raise AssertionError(f"The '{name}' field must be a string not longer than {bound}")
        return value

    return check
