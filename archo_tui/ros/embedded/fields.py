"""The checks of values assigned to a message's fields, and the copying of values.

The checks are those of rosidl's Python classes (AssertionError, bool is an int, a single int is not
a float), always on; but integers in an array of floats become floats, as without checks.
Copies behave like a trip over the wire: nothing is shared, float32 is rounded.
"""

from __future__ import annotations

import array
import math
import struct
from collections import UserString
from collections.abc import Callable, Sequence, Set
from typing import Any

from .idl import FLOAT32_MAX, FLOATS, INTEGERS, TYPE_CODES, FieldType

_FLOAT32 = struct.Struct("f")
_SEQUENCES: Any = (Sequence, Set, array.array)
_TYPES: dict[str, Any] = {"bool": bool, "string": str, "wstring": str, "byte": bytes}

Check = Callable[[Any], Any]


def check_of(name: str, kind: FieldType, message_class: Any) -> Check:
    """Return the check of a field, which returns what the message keeps.

    Numbers of an array become an array.array. A wrong value raises AssertionError.
    """
    fits, said = _element(kind, message_class)
    if not kind.is_array:

        def check(value: Any) -> Any:
            if not fits(value):
                raise AssertionError(f"The '{name}' field must be {said}, not {repr(value)[:60]}")
            return value

        return check
    code, size = TYPE_CODES.get(kind.base), kind.fixed_size
    most = kind.upper_bound if size is None else size
    length = "" if most is None else f" with length {'' if size else '<= '}{most}"
    each = said.removeprefix("a sub message ")
    refused = f"The '{name}' field must be a set or sequence{length} and each value {each}"

    def check_all(value: Any) -> Any:
        is_array = bool(code) and type(value) is array.array
        if is_array and size is None and value.typecode != code:
            raise AssertionError(f"The '{name}' array.array() must have the type code of '{code}'")
        if code and size is not None and isinstance(value, bytes):  # As numpy refuses them.
            raise ValueError(f"The '{name}' field takes numbers, not bytes: list(...) has them")
        if not _is_array(value):
            raise AssertionError(refused)
        if most is not None and not (size or 0) <= len(value) <= most:
            raise AssertionError(refused)
        if is_array and value.typecode == code:
            return value
        items = value.tolist() if hasattr(value, "tolist") else value
        if kind.base in FLOATS:
            try:
                items = [float(item) if isinstance(item, int) else item for item in items]
            except OverflowError:
                raise AssertionError(refused) from None
        if not all(map(fits, items)):
            raise AssertionError(refused)
        return array.array(code, items) if code else value

    return check_all


def _is_array(value: Any) -> bool:
    is_text = isinstance(value, (str, UserString))
    return not is_text and (isinstance(value, _SEQUENCES) or hasattr(value, "__array__"))  # numpy's


def _element(kind: FieldType, message_class: Any) -> tuple[Callable[[Any], bool], str]:
    """Return what tells if a single value fits, and what is wanted."""
    if message_class is not None:
        said = f"a sub message of type '{message_class.__name__}'"
        return lambda value: isinstance(value, message_class), said
    if kind.base in INTEGERS:
        low, high = INTEGERS[kind.base]
        said = f"of type 'int', in [{low}, {high}]"
        return lambda value: isinstance(value, int) and low <= value <= high, said
    if kind.base == "float64":
        return lambda value: isinstance(value, float), "of type 'float'"
    if kind.base == "float32":
        return (
            lambda v: isinstance(v, float) and (abs(v) <= FLOAT32_MAX or not math.isfinite(v)),
            f"of type 'float', in [-{FLOAT32_MAX}, {FLOAT32_MAX}]",
        )
    wanted, bound = _TYPES[kind.base], 1 if kind.base == "byte" else kind.string_bound
    longest = "" if bound is None else f", not longer than {bound}"
    return (
        lambda value: isinstance(value, wanted) and (bound is None or len(value) <= bound),
        f"of type '{wanted.__name__}'{longest}",
    )


def copier(kind: FieldType, check: Check, message_class: Any) -> Callable[[Any], Any] | None:
    """Return a function that copies a field's value, or None if the value needs no copy.

    The function rounds a float32. It checks a list again, which may have been changed after it was
    assigned, and raises AssertionError if an element or the length is wrong by now.
    """
    if kind.is_array:
        if message_class is not None:
            return lambda value: [item.__received__() for item in check(value)]
        return lambda value: check(value)[:] if type(value) is array.array else list(check(value))
    if message_class is not None:
        return message_class.__received__  # type: ignore[no-any-return]
    if kind.base == "float32":
        return lambda value: _FLOAT32.unpack(_FLOAT32.pack(value))[0]
    return None


def from_file(kind: FieldType, value: Any) -> Any:
    """Return the value of a constant or default from an interface file as a message keeps it."""
    if isinstance(value, list):
        return [from_file(kind, item) for item in value]
    return bytes([value]) if kind.base == "byte" else value


def default_of(kind: FieldType, message_class: Any) -> Any:
    """Return a new value for a field whose interface file gives no default: 0, "", [] and so on."""

    def one() -> Any:
        if message_class is not None:
            return message_class()
        if kind.base in INTEGERS:
            return 0
        return 0.0 if kind.base in FLOATS else {"bool": False, "byte": b"\x00"}.get(kind.base, "")

    return [one() for _ in range(kind.fixed_size or 0)] if kind.is_array else one()
