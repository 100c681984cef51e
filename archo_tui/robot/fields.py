"""The filling of message fields with values, each checked against the type of its field.

rosidl's classes check values only if ROS_PYTHON_CHECK_FIELDS=1 was set. Without it, a value that
does not fit is cut, and a list that is too short is filled up with whatever is in memory.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping
from typing import Any

import yaml

from archo_tui.robot.message_classes import EMPTY, load_nested
from archo_tui.robot.values import INTEGERS
from archo_tui.safe_text import harmless
from archo_tui.surrogates import has_lone_surrogate
from archo_tui.yaml_text.dump import flow

NESTED = re.compile(r"\w+/\w+")
# Types as rosidl writes them: sequence<string<8>, 3> holds at most three texts of at most eight
# characters each; `most` and `size` are such numbers.
_ARRAY = re.compile(r"sequence<(?P<of>.+?)(?:, *(?P<most>\d+))?>|(?P<each>.+)\[(?P<size>\d+)\]")
_STRING = re.compile(r"w?string(?:<(\d+)>)?")
_FLOAT32_MAX = 3.402823466e38  # The limit that rosidl's setters check.
_FLOAT32_LARGEST = 3.4028234663852886e38  # The largest float32; more is infinite on the wire.
_MARKS = ("\ufeff", "\ufffe")
_SHOWN = 40  # Characters of a wrong value that its error quotes.
# What rosidl's setters raise for a value that does not fit.
_REFUSED = (AssertionError, TypeError, ValueError, AttributeError, OverflowError)


def element_of(kind: str) -> str | None:
    """Return the type of the elements of an array type; None for any other type.

    Args:
        kind: The type as rosidl writes it: `sequence<double>`, `double[3]`.
    """
    found = _ARRAY.fullmatch(kind)
    return None if found is None else found["of"] or found["each"]


def put(message: Any, path: str, value: Any, where: str = "") -> None:
    """Set a field of a message to a value that was checked against the type of the field.

    Args:
        message: The message, which is changed.
        path: The dotted path of the field; no part of it may be an array.
        value: The value as plain Python data; for a field that is a message, a mapping.
        where: The path of the message itself, for errors.

    Raises:
        ValueError: In one line the field, the value, and what is allowed.
    """
    first, _, rest = path.partition(".")
    kinds = message.get_fields_and_field_types()
    where = f"{where}.{first}".lstrip(".")
    if first not in kinds:
        known = ", ".join(sorted(set(kinds) - {EMPTY})) or "it takes none"
        raise ValueError(harmless(f"there is no field {where}: {known}"))
    if rest:
        if not NESTED.fullmatch(kinds[first]):
            why = f"{where} is of type {kinds[first]}"
            raise ValueError(harmless(f"there is no field {where}.{rest}: {why}"))
        put(getattr(message, first), rest, value, where)
        return
    made = checked(kinds[first], value, where)
    try:
        setattr(message, first, made)
    except _REFUSED:
        raise ValueError(f"{where}: {_shown(value)} is not of type {kinds[first]}") from None


def filled(message: Any, values: Mapping[str, Any], where: str = "") -> Any:
    """Set fields of a message in place, and return the same message.

    Args:
        message: The message, which is changed; also before an error.
        values: The values by dotted path.
        where: The path of the message itself, for errors.

    Raises:
        ValueError: A value does not fit, as in `put`; or one path is inside of another one.
    """
    parts = sorted(path.split(".") for path in values)
    for outer, inner in itertools.pairwise(parts):  # A whole message would replace its fields.
        if inner[: len(outer)] == outer:
            fault = f"{'.'.join(inner)} is given twice, also by {'.'.join(outer)}"
            raise ValueError(harmless(f"{where}: {fault}".lstrip(": ")))
    for path, value in values.items():
        put(message, path, value, where)
    return message


def checked(kind: str, value: Any, where: str) -> Any:
    """Return a value in the form in which a field of a type takes it.

    A mapping becomes a message, a number for a `byte` becomes `bytes`, a number for a float field a
    float; other values stay as they are.

    Args:
        kind: The type, as rosidl writes it.
        value: The value as plain Python data.
        where: The path of the field, for errors.

    Raises:
        ValueError: In one line the field, the value, and what is allowed.
    """
    array, nested = _ARRAY.fullmatch(kind), NESTED.fullmatch(kind)
    if array is not None:
        return _list(array, value, where)
    if nested is not None:
        return _message(nested, value, where)
    try:
        return _single(kind, value)
    except ValueError as error:
        raise ValueError(f"{where}: {_shown(value)} {error}") from None


def _list(array: re.Match[str], value: Any, where: str) -> list[Any]:
    if not isinstance(value, list):
        raise ValueError(f"{where}: {_shown(value)} is not a list")
    size, most = array["size"], array["most"]
    if size is not None and len(value) != int(size):
        raise ValueError(f"{where}: {_shown(value)} has {len(value)} elements, not {size}")
    if most is not None and len(value) > int(most):
        raise ValueError(f"{where}: {_shown(value)} has {len(value)} elements, at most {most}")
    of = array["of"] or array["each"]
    return [checked(of, item, f"{where}[{place}]") for place, item in enumerate(value)]


def _message(nested: re.Match[str], value: Any, where: str) -> Any:
    """Return a new message of a nested type with the values of a mapping."""
    if not isinstance(value, Mapping):
        raise ValueError(f"{where}: {_shown(value)} is not the fields of {nested[0]}")
    message_class = load_nested(nested[0])
    if message_class is None:
        raise ValueError(f"{where}: {nested[0]} is not installed here")
    return filled(message_class(), value, where)


def _single(kind: str, value: Any) -> Any:
    """Return a value for a field that is no array and no message.

    Raises:
        ValueError: What is allowed; `checked` puts the field and the value before it.
    """
    text = _STRING.fullmatch(kind)
    if text is not None:
        if kind[0] == "w" and isinstance(value, str) and value.startswith(_MARKS):
            raise ValueError("begins with a byte order mark, which ROS removes")
        return _text(value, None if text[1] is None else int(text[1]))
    if kind in INTEGERS:
        if kind == "octet" and isinstance(value, bytes) and len(value) == 1:
            return value
        whole = _whole(value, *INTEGERS[kind])
        return bytes([whole]) if kind == "octet" else whole
    if kind in ("float", "double"):
        return _number(value, kind)
    if kind != "boolean":
        raise ValueError(f"is for a field of type {kind}, which cannot be set from here")
    if not isinstance(value, bool):
        raise ValueError("is not true or false")
    return value


def _whole(value: Any, low: int, high: int) -> int:
    """Return a value that is a whole number within low .. high; raise ValueError for any other."""
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError("is not a whole number")
    if not low <= value <= high:
        raise ValueError(f"is not within {low} .. {high}")
    return value


def _number(value: Any, kind: str) -> float:
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        raise ValueError("is not a number")
    try:
        number = float(value)
    except OverflowError:
        raise ValueError("is too large for a number") from None
    if kind == "float" and math.isfinite(number) and abs(number) > _FLOAT32_MAX:
        if abs(number) > _FLOAT32_LARGEST:
            raise ValueError(f"is not within -{_FLOAT32_MAX} .. {_FLOAT32_MAX}")
        return math.copysign(_FLOAT32_MAX, number)  # As a float32 it is the same number.
    return number


def _text(value: Any, most: int | None) -> str:
    if not isinstance(value, str):
        raise ValueError("is not a text")
    if most is not None and len(value) > most:
        raise ValueError(f"has {len(value)} characters, at most {most}")
    if "\0" in value:  # It would end the text in DDS.
        raise ValueError("contains a null character")
    if has_lone_surrogate(value):
        raise ValueError("contains half of a surrogate pair")
    return value


def _shown(value: Any) -> str:
    try:
        text = flow(value)
    except yaml.YAMLError:  # A value that no person can type.
        text = str(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]} ..."
