"""Values as a person writes them, and the filling of message fields with values that fit.

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

from archo_tui.base.safe_text import harmless, safe
from archo_tui.base.surrogates import has_lone_surrogate
from archo_tui.base.yaml_text.dump import flow
from archo_tui.robot.messages.types import ARRAY, INTEGERS, NESTED, STRING, kinds, load_nested
from archo_tui.robot_file.model import GoalKind, MessageField

_FLOAT32_MAX = 3.402823466e38  # The limit that rosidl's setters check.
_FLOAT32_LARGEST = 3.4028234663852886e38  # The largest float32; more is infinite on the wire.
_MARKS = ("\ufeff", "\ufffe")
_SHOWN = 40  # Characters of a wrong value that its error quotes.
# What rosidl's setters raise for a value that does not fit.
_REFUSED = (AssertionError, TypeError, ValueError, AttributeError, OverflowError)


def text_of(value: Any) -> str:
    """Return a value as a person writes it, in one line that is safe to show; `--` for None."""
    if value is None:
        return "--"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(text_of(item) for item in value)}]"
    return safe(str(value))


def same(a: Any, b: Any) -> bool:
    """Return True for equal values; unlike with `==`, NaN is the same as NaN."""
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    both_nan = isinstance(a, float) and isinstance(b, float) and a != a and b != b
    return both_nan or bool(a == b)


def fits_an_integer(value: int) -> bool:
    """Return True if an int64 or a uint64 can hold the number."""
    return INTEGERS["int64"][0] <= value <= INTEGERS["uint64"][1]


def number(value: Any, low: float, high: float) -> float | None:
    """Return a finite number within low .. high as a float; None for anything else, a bool too."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if math.isfinite(value) and low <= value <= high else None


def put(message: Any, path: str, value: Any, where: str = "") -> None:
    """Set the field at a dotted path to a value that fits its type; else raise ValueError."""
    first, _, rest = path.partition(".")
    found = kinds(message)
    where = f"{where}.{first}".lstrip(".")
    if first not in found:
        known = ", ".join(sorted(found)) or "it takes none"
        raise ValueError(harmless(f"there is no field {where}: {known}"))
    if rest:
        if not NESTED.fullmatch(found[first]):
            why = f"{where} is of type {found[first]}"
            raise ValueError(harmless(f"there is no field {where}.{rest}: {why}"))
        put(getattr(message, first), rest, value, where)
        return
    made = checked(found[first], value, where)
    try:
        setattr(message, first, made)
    except _REFUSED:
        raise ValueError(f"{where}: {_shown(value)} is not of type {found[first]}") from None


def filled(message: Any, values: Mapping[str, Any], where: str = "") -> Any:
    """Set fields of a message, by dotted path, as `put` does, and return the same message."""
    parts = sorted(path.split(".") for path in values)
    for outer, inner in itertools.pairwise(parts):  # A whole message would replace its fields.
        if inner[: len(outer)] == outer:
            fault = f"{'.'.join(inner)} is given twice, also by {'.'.join(outer)}"
            raise ValueError(harmless(f"{where}: {fault}".lstrip(": ")))
    for path, value in values.items():
        put(message, path, value, where)
    return message


def checked(kind: str, value: Any, where: str) -> Any:
    """Return a value as a field of a type takes it, mappings as messages; else raise ValueError."""
    array, nested = ARRAY.fullmatch(kind), NESTED.fullmatch(kind)
    if array is not None:
        return _list(array, value, where)
    if nested is not None:
        return _message(kind, value, where)
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


def _message(kind: str, value: Any, where: str) -> Any:
    if not isinstance(value, Mapping):
        raise ValueError(f"{where}: {_shown(value)} is not the fields of {kind}")
    message_class = load_nested(kind)
    if message_class is None:
        raise ValueError(f"{where}: {kind} is not installed here")
    return filled(message_class(), value, where)


def _single(kind: str, value: Any) -> Any:
    """Return a value for a field that is no array and no message; ValueError if it does not fit."""
    text = STRING.fullmatch(kind)
    if text is not None:
        if kind[0] == "w" and isinstance(value, str) and value.startswith(_MARKS):
            raise ValueError("begins with a byte order mark, which ROS removes")
        return _text(value, None if text["most"] is None else int(text["most"]))
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
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError("is not a whole number")
    if not low <= value <= high:
        raise ValueError(f"is not within {low} .. {high}")
    return value


def _number(value: Any, kind: str) -> float:
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        raise ValueError("is not a number")
    try:
        found = float(value)
    except OverflowError:
        raise ValueError("is too large for a number") from None
    if kind == "float" and math.isfinite(found) and abs(found) > _FLOAT32_MAX:
        if abs(found) > _FLOAT32_LARGEST:
            raise ValueError(f"is not within -{_FLOAT32_MAX} .. {_FLOAT32_MAX}")
        return math.copysign(_FLOAT32_MAX, found)  # As a float32 it is the same number.
    return found


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


def goal_request(action_type: Any, kind: GoalKind, values: Mapping[str, Any]) -> Any:
    """Return a goal with the fixed and the typed values, by path, or raise ValueError.

    A typed yaw in degrees, which the robot file says to convert, becomes a quaternion.
    """
    made = action_type.Goal()
    for path, value in itertools.chain(kind.fixed.items(), values.items()):
        given = kind.form.get(path)
        put(made, path, _quaternion(path, value) if given is not None and given.convert else value)
    return made


def _quaternion(path: str, degrees: Any) -> dict[str, float]:
    yaw: float = checked("double", degrees, path)
    if not math.isfinite(yaw):
        raise ValueError(f"{path}: {flow(yaw)} is not a finite number")
    half = math.radians(yaw) / 2
    return {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}


Fields = MessageField | tuple[MessageField, ...]  # The source of one reading.


def read(given: Fields | None, message: Any) -> Any:
    """Return the value that a robot file reads from a message; None if the field is missing."""
    if isinstance(given, tuple):
        flags = [flag(_read(field, message)) for field in given]
        return True if True in flags else None if None in flags else False
    return None if given is None else _read(given, message)


def _read(field: MessageField, message: Any) -> Any:
    """Return the value of one field, compared or scaled as the robot file says."""
    value = message
    for name in field.field.split("."):
        value = getattr(value, name, None)
    if value is None:
        return None
    if field.equals is not None:
        return bool(value == field.equals)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    if field.beyond is not None:
        return abs(value) > field.beyond if math.isfinite(value) else None
    if (field.scale, field.offset) == (1.0, 0.0):
        return value  # A count stays a whole number.
    return value * field.scale + field.offset


def integer(value: Any) -> int | None:
    """Return a whole number that fits into 64 bits; None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int):
        return None
    low, high = INTEGERS["int64"]
    return value if low <= value <= high else None


def flag(value: Any) -> bool | None:
    """Return a bool; None for anything else."""
    return value if isinstance(value, bool) else None


def as_received(value: Any) -> str:
    """Return a short text for a value that is no reading; it may hold any characters."""
    return f"{value:g}" if isinstance(value, float) else str(value)[:20]


def yaw(quaternion: Any) -> float | None:
    """Return the yaw of a quaternion in degrees, -180 to 180; None for anything else."""
    parts = [number(getattr(quaternion, name, None), -math.inf, math.inf) for name in "xyzw"]
    if None in parts or not any(parts):
        return None
    x, y, z, w = (part or 0.0 for part in parts)
    sine, cosine = 2.0 * (w * z + x * y), w * w + x * x - y * y - z * z
    return math.degrees(math.atan2(sine, cosine))
