"""The checks of values assigned to a message's fields, and the copying of values.

The checks are those of rosidl's Python classes (AssertionError, bool is an int, a single int is not
a float), always on; but integers in an array of floats become floats, as without checks.
Copies behave like a trip over the wire: nothing is shared, float32 is rounded.
"""

from __future__ import annotations

import array
import math
import struct
import sys
from collections import UserString
from collections.abc import Callable, Sequence, Set
from typing import Any

from .fixed_array import FixedArray, name_of
from .idl_types import FLOAT32_MAX, FLOATS, INTEGERS, TYPE_CODES, FieldType

FLOAT64_MAX = sys.float_info.max
_FLOAT32 = struct.Struct("f")

Check = Callable[[Any], Any]
Copy = Callable[[Any], Any]


def round_to_float32(value: float) -> float:
    """Return the nearest value that four bytes can carry, as a receiver would read it.

    Raises:
        OverflowError: The value is too large for a float32.
    """
    result: float = _FLOAT32.unpack(_FLOAT32.pack(value))[0]
    return result


def scalar_check(name: str, base: str, bound: int | None, message_class: type | None) -> Check:
    """Return a check for a field of one value, or for one element of an array.

    The check returns a valid value unchanged and raises AssertionError for any other.

    Args:
        name: The field, for the error.
        base: The type of one value, as FieldType has it.
        bound: The longest string, in characters; None for no bound.
        message_class: The class of a nested message; None for a primitive.
    """
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
    """Return a check for an array field, which returns what the message keeps.

    The check returns a valid sequence or set itself, without a copy, but converts numbers: to an
    array.array, or to a FixedArray for an array of fixed size. Any other value raises
    AssertionError, and bytes for numbers of a fixed size ValueError.

    Args:
        name: The field, for the error.
        kind: The type of the field.
        element: The check of one element, from `scalar_check`.
    """
    code, size = TYPE_CODES.get(kind.base), kind.fixed_size
    most = kind.upper_bound if size is None else size
    takes_integers = kind.base in FLOATS

    def refused(why: str) -> AssertionError:
        return AssertionError(f"The '{name}' {why}")

    def check(value: Any) -> Any:
        if code and size is None and type(value) is array.array:
            if value.typecode != code:
                raise refused(f"array.array() must have the type code of '{code}'")
            if most is not None and len(value) > most:
                raise refused(f"array.array() must have a size <= {most}")
            return value
        if code and size is not None and _is_ndarray(value):
            if str(value.dtype) != name_of(code):
                raise refused(f"numpy.ndarray() must have the dtype of 'numpy.{name_of(code)}'")
            if value.size != size:
                raise refused(f"numpy.ndarray() must have a size of {size}")
            return value if type(value) is FixedArray else FixedArray(code, value.tolist())
        if not is_array(value):
            raise refused(f"field must be a set or sequence{_expected(kind)}")
        if code is None:
            return value
        if size is None:
            return array.array(code, value)
        if isinstance(value, bytes):  # numpy would read bytes as digits.
            raise ValueError(f"invalid literal for int() with base 10: {value!r}")
        return FixedArray(code, value)

    def is_array(value: Any) -> bool:
        if isinstance(value, (str, UserString)) or not isinstance(value, (Sequence, Set)):
            return False
        if most is not None and not (size or 0) <= len(value) <= most:
            return False
        try:
            for item in value:
                # array.array makes floats of integers, as in rosidl without checks.
                element(float(item) if takes_integers and isinstance(item, int) else item)
        except (AssertionError, OverflowError):
            return False
        return True

    return check


def _is_ndarray(value: Any) -> bool:
    return isinstance(value, FixedArray) or type(value).__name__ == "ndarray"


def _expected(kind: FieldType) -> str:
    """Return the end of the error text for a wrong value of an array field: what was expected."""
    length = ""
    if kind.fixed_size is not None:
        length = f" with length {kind.fixed_size}"
    elif kind.upper_bound is not None:
        length = f" with length <= {kind.upper_bound}"
    return f"{length} and each value of type '{_python_type(kind.base)}'{_limits(kind)}"


def _limits(kind: FieldType) -> str:
    if kind.base in INTEGERS:
        low, high = INTEGERS[kind.base]
        return f" and each {'' if low < 0 else 'unsigned '}integer in [{low}, {high}]"
    if kind.base in FLOATS:
        word, most = ("double", FLOAT64_MAX) if kind.base == "float64" else ("float", FLOAT32_MAX)
        return f" and each {word} in [{-most:f}, {most:f}]"
    if kind.string_bound is not None:
        return f" and each string value not longer than {kind.string_bound}"
    return ""


def _python_type(base: str) -> str:
    if base in INTEGERS:
        return "int"
    if base in FLOATS:
        return "float"
    return {"string": "str", "wstring": "str", "byte": "bytes"}.get(base, base.rpartition("/")[2])


def copier(kind: FieldType, check: Check, message_class: Any) -> Copy | None:
    """Return a function that copies a field's value, or None if the value needs no copy.

    The function rounds a float32. It checks a list again, which may have been changed after it was
    assigned, and raises AssertionError if an element or the length is wrong by now.

    Args:
        kind: The type of the field.
        check: The check of the whole field.
        message_class: The class of a nested message; None for a primitive.
    """
    if kind.is_array:
        code = TYPE_CODES.get(kind.base)
        if code and kind.fixed_size is not None:
            return FixedArray.copy
        if code:
            return lambda value: value[:]
        if message_class is not None:
            return lambda value: [item.__received__() for item in check(value)]
        # The list may have been changed since: check again.
        return lambda value: list(check(value))
    if message_class is not None:
        return message_class.__received__  # type: ignore[no-any-return]
    return round_to_float32 if kind.base == "float32" else None


def from_file(kind: FieldType, value: Any) -> Any:
    """Return the value of a constant or default from an interface file as a message keeps it.

    A byte becomes `bytes`; a list becomes a new list.
    """
    if isinstance(value, list):
        return [from_file(kind, item) for item in value]
    return bytes([value]) if kind.base == "byte" else value


def default_of(kind: FieldType, message_class: Any) -> Any:
    """Return a new value for a field whose interface file gives no default: 0, "", False and so on.

    The default of a nested message is a new message, of an array of fixed size a list of its
    elements' defaults, and of any other array an empty list.
    """

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
