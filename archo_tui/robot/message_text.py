"""A received message for people and programs: as YAML, as JSON, and its fields by dotted path.

Long arrays are described instead of shown. All of it may take long for large messages: call it on
no thread that others wait for.
"""

from __future__ import annotations

import json
import math
import re
import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

from archo_tui.errors import ArchoError
from archo_tui.nearest import nearest_hint
from archo_tui.robot.array_summary import as_list, summarize
from archo_tui.robot.fields import NESTED, element_of
from archo_tui.robot.message_classes import EMPTY
from archo_tui.safe_text import safe
from archo_tui.yaml_text.dump import block, flow

MAX_ELEMENTS = 20  # Of an array that a text shows.
_MAX_LINES, _MAX_CHARACTERS = 1_000, 100_000  # Of a text.
_MAX_TEXT = 500  # Characters of a string in a text.
_MAX_JSON = 100_000  # Characters: a program that reads slowly is sent no more at once.
_JSON_ELEMENTS = (10_000, 1_000, MAX_ELEMENTS)  # Of an array, the first that fits _MAX_JSON.
_PART = re.compile(r"(\w+)((?:\[\d{1,9}\])*)")


class FieldValue(NamedTuple):
    """A field of a message: its path, its type as rosidl writes it, and its value."""

    path: str
    type: str
    value: Any


def find_field(message: Any, path: str) -> FieldValue:
    """Return the field at a path such as `pose.position.x` or `ranges[3]`.

    Raises:
        ArchoError: There is no such field or element; the line names the nearest, or all.
    """
    value, kind, where = message, "", ""
    for part in path.split("."):
        found = _PART.fullmatch(part)
        kinds = _kinds(value) if hasattr(value, "get_fields_and_field_types") else {}
        if found is None or found[1] not in kinds:
            known = f": {where or 'the message'} has {', '.join(kinds)}" if kinds else ""
            hint = nearest_hint(part.partition("[")[0], kinds) or known
            raise ArchoError(f"there is no field {safe(f'{where}.{part}'.lstrip('.'))}{hint}")
        value, kind = getattr(value, found[1]), kinds[found[1]]
        where = f"{where}.{found[1]}".lstrip(".")
        for index in map(int, re.findall(r"\d+", found[2])):
            element = element_of(kind)
            if element is None or index >= len(value):
                size = "is no array" if element is None else f"has {len(value)} elements"
                raise ArchoError(f"there is no {where}[{index}]: {where} {size}")
            kind, where = element, f"{where}[{index}]"
            value = as_list(value[index : index + 1])[0]
    return FieldValue(path, kind, value)


def as_text(message: Any, paths: Sequence[str] = ()) -> str:
    """Return a message as YAML, as `ros2 topic echo` prints it, or chosen fields, one a line.

    Arrays of more than 20 elements are described: `float32[360], 0.1 .. 4.0`. Long strings are cut,
    and lines after the first 1,000 are counted.

    Args:
        message: The message.
        paths: The paths of the fields; () for the whole message.

    Raises:
        ArchoError: There is no such field, or the text would be longer than 100,000 characters.
    """
    if paths:
        found = [find_field(message, path) for path in paths]
        text = "\n".join(f"{f.path}: {flow(_value(f.value, f.type, _TEXT))}" for f in found)
    else:
        text = block(_message(message, _TEXT)).rstrip()
    lines = text.splitlines()
    if len(text) > _MAX_CHARACTERS:
        raise ArchoError(f"not shown: more than {_MAX_CHARACTERS // 1000} kB as text: name fields")
    if len(lines) > _MAX_LINES:
        lines[_MAX_LINES:] = [f"... and {len(lines) - _MAX_LINES} more lines: name fields"]
    return "\n".join(lines)


def as_data(message: Any, paths: Sequence[str] = ()) -> dict[str, Any]:
    """Return a message, or chosen fields by path, as data for JSON.

    `nan` and `inf` are texts. If the JSON would be longer than 100,000 characters, arrays of more
    than 1,000 elements become objects with their type and range, then those of more than 20, and
    strings are cut. Arrays of more than 10,000 elements always become such objects.

    Args:
        message: The message.
        paths: The paths of the fields; () for the whole message.

    Raises:
        ArchoError: There is no such field, or the JSON would be too long.
    """
    found = [find_field(message, path) for path in paths]
    for elements in _JSON_ELEMENTS:
        form = _Form(is_json=True, elements=elements)
        data: dict[str, Any] = (
            {f.path: _value(f.value, f.type, form) for f in found}
            if paths
            else _message(message, form)
        )
        if len(json.dumps(data)) <= _MAX_JSON:
            return data
    raise ArchoError(f"not shown: more than {_MAX_JSON // 1000} kB as JSON: name fields")


class _Form(NamedTuple):
    """The form of values: for JSON or a text, and the most elements that an array shows."""

    is_json: bool
    elements: int


_TEXT = _Form(is_json=False, elements=MAX_ELEMENTS)


def _message(message: Any, form: _Form) -> dict[str, Any]:
    return {
        name: _value(getattr(message, name), kind, form) for name, kind in _kinds(message).items()
    }


def _kinds(message: Any) -> dict[str, str]:
    kinds: dict[str, str] = message.get_fields_and_field_types()
    return {name: kind for name, kind in kinds.items() if name != EMPTY}


def _value(value: Any, kind: str, form: _Form) -> Any:
    """Return the value of a field as a form has it.

    Args:
        value: The value as rclpy has it.
        kind: Its type, as rosidl writes it.
        form: The form.
    """
    element = element_of(kind)
    if element is not None:
        if len(value) > form.elements:
            return _description(value, element, form)
        return [_value(item, element, form) for item in as_list(value)]
    if NESTED.fullmatch(kind):
        return _message(value, form)
    if isinstance(value, str):
        is_whole = form.is_json and form.elements > MAX_ELEMENTS
        return value if is_whole else shortened(value)
    if form.is_json and isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return primitive(value, kind)


def primitive(value: Any, kind: str) -> Any:
    """Return a bool, number or text as it is shown; texts as they are.

    A byte becomes its number, several bytes a text in hexadecimal, a float32 the shortest number
    that stands for it.

    Args:
        value: The value as rclpy has it.
        kind: Its type, as rosidl writes it.
    """
    if isinstance(value, bytes):
        return value[0] if len(value) == 1 else value.hex(" ")
    return shortest(value) if isinstance(value, float) and kind == "float" else value


def shortened(text: str) -> str:
    """Return a text, cut after 500 characters with ` ...` behind it."""
    return text if len(text) <= _MAX_TEXT else f"{text[:_MAX_TEXT]} ..."


def shortest(value: float) -> float:
    """Return the number with the fewest digits that is the same float32: 0.1 for 0.10000000149."""
    for digits in range(6, 10):
        short = float(f"{value:.{digits}g}")
        if abs(short) < 3.4e38 and struct.pack("f", short) == struct.pack("f", value):
            return short
    return value


def _description(value: Any, element: str, form: _Form) -> Any:
    """Return type and length of a long array, and its range or its first bytes.

    Returns:
        An object for JSON, or a text.
    """
    summary = summarize(value, element)
    told: dict[str, Any] = {"type": summary.type}
    if summary.first:
        told["first"] = summary.first
    if summary.least is not None:
        told["least"] = _value(summary.least, element, form)
        told["greatest"] = _value(summary.greatest, element, form)
    if summary.nan:
        told["nan"] = summary.nan
    if form.is_json:
        return told
    words = [told["type"]]
    if "least" in told:
        words.append(f"{told['least']} .. {told['greatest']}")
    if summary.nan:
        words.append(f"{summary.nan} nan")
    return ", ".join(words) + (f", {summary.first} ..." if summary.first else "")
