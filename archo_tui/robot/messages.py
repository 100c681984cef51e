"""Messages of any type: their fields by dotted path, goals from values, and texts of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from archo_tui.robot.fields import NESTED, checked, put
from archo_tui.robot.message_classes import EMPTY
from archo_tui.robot.state import TypedField
from archo_tui.robot.values import text_of
from archo_tui.robot_file.model import GoalKind
from archo_tui.safe_text import harmless
from archo_tui.yaml_text.dump import flow

_SHOWN = 20  # Elements of an array that a text shows.


def flat_fields(message: Any) -> Iterator[TypedField]:
    """Yield each field of a message with its type and value, in order.

    A nested message is replaced by its own fields, with dotted paths. Values are plain Python data.
    """
    for path, kind, value in _fields(message):
        yield TypedField(path, kind, _plain(value))


def _fields(message: Any, before: str = "") -> Iterator[tuple[str, str, Any]]:
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        if name == EMPTY:
            continue
        if NESTED.fullmatch(kind):
            yield from _fields(value, f"{before}{name}.")
        else:
            yield before + name, kind, value


def types(message: Any, before: str = "") -> dict[str, str]:
    """Return the type of every field by its dotted path, as rosidl writes it.

    Nested messages and their fields are included, but nothing inside of arrays.

    Args:
        message: The message.
        before: The path of the message itself with a dot behind it, or "".
    """
    found = {}
    for name, kind in message.get_fields_and_field_types().items():
        if name == EMPTY:
            continue
        found[before + name] = kind
        if NESTED.fullmatch(kind):
            found |= types(getattr(message, name), f"{before}{name}.")
    return found


@cache
def paths(message_class: Any) -> frozenset[str]:
    """Return the dotted paths of all fields of a message class, as `types` does."""
    return frozenset(types(message_class()))


def goal_request(action_type: Any, kind: GoalKind, values: Mapping[str, Any]) -> Any:
    """Return a goal message with the fixed values of the robot file and the typed values.

    A typed value that the file says to convert, a yaw in degrees, becomes a quaternion.

    Args:
        action_type: The class of the action.
        kind: The kind of goal, which has the fixed values and conversions.
        values: The typed values by dotted path.

    Raises:
        ValueError: A value does not fit its field, as in `fields.put`.
    """
    made = action_type.Goal()
    for path, value in itertools.chain(kind.fixed.items(), values.items()):
        given = kind.form.get(path)
        put(made, path, _quaternion(path, value) if given is not None and given.convert else value)
    return made


def _quaternion(path: str, degrees: Any) -> dict[str, float]:
    """Return the quaternion of a yaw, as a mapping.

    Args:
        path: The path of the field, for errors.
        degrees: The yaw in degrees, counterclockwise.

    Raises:
        ValueError: The yaw is no finite number.
    """
    half = math.radians(finite(path, degrees)) / 2
    return {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}


def finite(where: str, value: Any) -> float:
    """Return a value as a finite float; raise ValueError for any other.

    Args:
        where: The path of its field, for errors.
        value: The value.

    Raises:
        ValueError: The value is no number, or not finite.
    """
    number: float = checked("double", value, where)
    if not math.isfinite(number):
        raise ValueError(f"{where}: {flow(number)} is not a finite number")
    return number


def text(message: Any) -> str:
    """Return every field and its value in one line that is safe to show: `x 1.5, name abc`.

    Fields with an empty text are left out; arrays are cut after 20 elements, the line after 500
    characters.
    """
    values = ((path, _short(value)) for path, _, value in _fields(message))
    return harmless(", ".join(f"{path} {value}" for path, value in values if value))


def as_yaml(message: Any) -> str:
    """Return a message in one line of YAML, as the `ros2` command takes it: `{pose: {x: 1.0}}`."""
    return flow(_plain(message, as_bytes=True))


def as_data(message: Any) -> Any:
    """Return a message as JSON has it: objects, lists, and null for a number that is not finite.

    Many values take long: call this on no thread that others wait for.
    """
    return _finite(_plain(message))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _short(value: Any) -> str:
    value = _listed(value)
    if isinstance(value, list):
        more = ", ..." if len(value) > _SHOWN else ""
        return f"[{', '.join(_short(item) for item in value[:_SHOWN])}{more}]"
    if _is_message(value):
        return f"{{{text(value)}}}"
    return f"{value:g}" if isinstance(value, float) else text_of(_plain(value))


def _plain(value: Any, as_bytes: bool = False) -> Any:
    """Return messages as mappings, arrays as lists, a byte as a number, all else as it is.

    Args:
        value: The value of a field, or a message.
        as_bytes: True to keep a byte as `bytes`: the `ros2` command would take a number for a
            length.
    """
    value = _listed(value)
    if isinstance(value, list):
        return [_plain(item, as_bytes) for item in value]
    if _is_message(value):
        names = [name for name in value.get_fields_and_field_types() if name != EMPTY]
        return {name: _plain(getattr(value, name), as_bytes) for name in names}
    return value[0] if isinstance(value, bytes) and not as_bytes else value


def _listed(value: Any) -> Any:
    """Return arrays and tuples, also those of NumPy, as lists, and other values as they are."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def _is_message(value: Any) -> bool:
    return hasattr(value, "get_fields_and_field_types")
