"""Messages of any type: their fields by dotted path, filled from what was typed, and as text."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from archo_tui.robot.interfaces import EMPTY, load
from archo_tui.robot.state import Leaf
from archo_tui.robot.text import harmless
from archo_tui.robot.values import text_of
from archo_tui.robots.model import GoalKind

_NESTED = re.compile(r"(\w+)/(\w+)")
_ARRAY = re.compile(r"sequence<([^,<>]+(?:<\d+>)?)(?:, *\d+)?>|(.+)\[\d+\]")
_SHOWN = 20  # elements of an array that are shown
_REFUSED = (AssertionError, TypeError, ValueError, AttributeError, OverflowError)  # of setters


def leaves(message: Any, before: str = "") -> Iterator[Leaf]:
    """Every field of a message and of the messages in it, in their order."""
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        if name == EMPTY:
            continue
        if _NESTED.fullmatch(kind):
            yield from leaves(value, f"{before}{name}.")
        else:
            yield Leaf(before + name, kind, _plain(value))


def types(message: Any, before: str = "") -> dict[str, str]:
    """The type of every field by its dotted path, those that are messages included."""
    found = {}
    for name, kind in message.get_fields_and_field_types().items():
        if name == EMPTY:
            continue
        found[before + name] = kind
        if _NESTED.fullmatch(kind):
            found |= types(getattr(message, name), f"{before}{name}.")
    return found


@cache
def paths(message_class: Any) -> frozenset[str]:
    """The dotted paths of all fields, those that are messages included."""
    return frozenset(types(message_class()))


def put(message: Any, path: str, value: Any) -> None:
    """Set the field at a dotted path, whole messages from mappings.

    Raises ValueError with one line that says which field takes what.
    """
    first, _, rest = path.partition(".")
    kinds = message.get_fields_and_field_types()
    if first not in kinds:
        raise ValueError(f"there is no field {first}: {', '.join(sorted(set(kinds) - {EMPTY}))}")
    if rest:
        put(getattr(message, first), rest, value)
        return
    try:
        made = _made(kinds[first], value)
    except ValueError as error:
        raise ValueError(f"{first}: {error}") from None
    try:
        setattr(message, first, made)
    except _REFUSED:
        raise ValueError(f"{first}: not a value of type {kinds[first]}") from None


def _made(kind: str, value: Any) -> Any:
    """The value as a message of that kind takes it."""
    array = _ARRAY.fullmatch(kind)
    if array is not None:
        if not isinstance(value, list):
            raise ValueError(f"not a list: {text_of(value)}")
        return [_made(array[1] or array[2], item) for item in value]
    nested = _NESTED.fullmatch(kind)
    if nested is not None:
        if not isinstance(value, Mapping):
            raise ValueError(f"not fields of {kind}: {text_of(value)}")
        made = load(f"{nested[1]}/msg/{nested[2]}")()
        for name, item in value.items():
            put(made, str(name), item)
        return made
    if kind in ("float", "double") and type(value) is int:
        return float(value)
    if kind == "octet" and type(value) is int:
        return bytes([value])
    return value


def filled(message: Any, values: Mapping[str, Any]) -> Any:
    """The message with values by dotted path. Raises ValueError as `put` does."""
    for path, value in values.items():
        put(message, path, value)
    return message


def goal(action_type: Any, kind: GoalKind, values: Mapping[str, Any]) -> Any:
    """The goal that a robot file and what was typed make. Raises ValueError as `put` does."""
    made = action_type.Goal()
    for path, value in itertools.chain(kind.fixed.items(), values.items()):
        given = kind.form.get(path)
        if given is not None and given.convert == "yaw":
            half = math.radians(value) / 2
            value = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
        put(made, path, value)
    return made


def text(message: Any) -> str:
    """Every field and its value in one line."""
    return harmless(", ".join(f"{leaf.path} {_short(leaf.default)}" for leaf in leaves(message)))


def as_yaml(message: Any) -> str:
    """The message as `ros2` takes it on its command line: `{pose: {x: 1.0}}`."""
    parts = []
    for name, kind in message.get_fields_and_field_types().items():
        if name == EMPTY:
            continue
        value = getattr(message, name)
        nested = _NESTED.fullmatch(kind)
        parts.append(f"{name}: {as_yaml(value) if nested else _flow(_plain(value))}")
    return f"{{{', '.join(parts)}}}"


def _flow(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_flow(item) for item in value)}]"
    if hasattr(value, "get_fields_and_field_types"):
        return as_yaml(value)
    if isinstance(value, str):
        return value if re.fullmatch(r"[A-Za-z_][\w/]*", value) else f'"{value}"'
    return text_of(value)


def _short(value: Any) -> str:
    if isinstance(value, list):
        more = ", ..." if len(value) > _SHOWN else ""
        return f"[{', '.join(_short(item) for item in value[:_SHOWN])}{more}]"
    if hasattr(value, "get_fields_and_field_types"):
        return f"{{{text(value)}}}"
    return f"{value:g}" if isinstance(value, float) else text_of(value)


def _plain(value: Any) -> Any:
    """Arrays, numpy's too, as lists."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value
