"""Conversion of our own types to JSON values and back, strictly, since a file may hold anything."""

from __future__ import annotations

import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache
from typing import Any, Union, get_args, get_origin, get_type_hints

from archo_tui.robot.audit_records import json_safe
from archo_tui.safe_text import harmless

_MAX_DEPTH = 4  # Of nested lists.


def to_data(value: Any) -> Any:
    """Return a value as JSON has it: a dataclass or named tuple as an object, an Enum by name.

    Sets become sorted lists. NaN, infinity and integers beyond 64 bits become texts, which
    `from_data` refuses where a number is due.
    """
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return {name: to_data(part) for name, part in zip(value._fields, value, strict=True)}
    if is_dataclass(value):
        return {field.name: to_data(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(name): to_data(part) for name, part in value.items()}
    if isinstance(value, frozenset):
        return sorted(value)
    if isinstance(value, (list, tuple)):
        return [to_data(part) for part in value]
    return value if value is None or isinstance(value, (str, bool)) else json_safe({"": value})[""]


def from_data(kind: Any, data: Any) -> Any:
    """Build a value of a type from JSON data; missing fields get their defaults.

    Unknown fields are ignored. Texts become safe for a terminal, and are cut to 500 characters.

    Raises:
        TypeError: A part of the data is of another type, or a required field is missing.
        ValueError: A tuple has another length.
        KeyError: An Enum has no such name.
    """
    origin, inner = get_origin(kind), get_args(kind)
    if kind is Any:
        return _plain_value(data, 0)
    if origin in (Union, types.UnionType):
        return (
            None if data is None else from_data(next(k for k in inner if k is not _NONE_TYPE), data)
        )
    if origin is tuple and inner[-1] is Ellipsis:
        return tuple([from_data(inner[0], part) for part in _require_type(list, data)])
    if origin is tuple:
        return tuple(
            [from_data(*pair) for pair in zip(inner, _require_type(list, data), strict=True)]
        )
    if origin is frozenset:
        return frozenset([from_data(inner[0], part) for part in _require_type(list, data)])
    if origin is Mapping or (isinstance(origin, type) and issubclass(origin, Mapping)):
        items = _require_type(dict, data).items()
        return {harmless(name): from_data(inner[1], part) for name, part in items}
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind[_require_type(str, data)]
    if kind in (str, int, bool, float):
        return _scalar_value(kind, data)
    hints = _type_hints(kind)
    given = _require_type(dict, data)
    return kind(**{name: from_data(hints[name], given[name]) for name in hints if name in given})


_NONE_TYPE = type(None)


@lru_cache
def _type_hints(kind: Any) -> Mapping[str, Any]:
    return get_type_hints(kind)


def _scalar_value(kind: type, data: Any) -> Any:
    if kind is float and isinstance(data, int) and not isinstance(data, bool):
        return float(data)
    found = _require_type(kind, data)
    return harmless(found) if kind is str else found


def _require_type(kind: type, data: Any) -> Any:
    if type(data) is not kind:
        raise TypeError(f"{kind.__name__} expected")
    return data


def _plain_value(data: Any, depth: int) -> Any:
    """Return None, a number, a text, or lists of them, for a field of type Any.

    Texts become safe for a terminal, and are cut to 500 characters.

    Raises:
        TypeError: The data are anything else, or lists nested too deeply.
    """
    if isinstance(data, str):
        return harmless(data)
    if isinstance(data, list) and depth < _MAX_DEPTH:
        return [_plain_value(part, depth + 1) for part in data]
    if data is None or isinstance(data, (bool, int, float)):
        return data
    raise TypeError("a number, a text or a list expected")
