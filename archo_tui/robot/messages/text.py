"""A message for people and programs: as YAML, as JSON, in one line, and its fields by path."""

from __future__ import annotations

import json
import math
import re
import struct
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.base.safe_text import harmless, safe
from archo_tui.base.yaml_text.dump import block, flow
from archo_tui.robot.messages.types import (
    NESTED,
    TypedField,
    element_of,
    kinds,
    leaves,
    ros2msg_type,
)
from archo_tui.robot.messages.values import text_of

MAX_ELEMENTS = 20  # Of an array that a text shows.
_MAX_LINES, _MAX_CHARACTERS = 1_000, 100_000  # Of a text.
_MAX_TEXT = 500  # Characters of a string in a text.
_MAX_JSON = 100_000  # Characters: a program that reads slowly is sent no more at once.
_JSON_ELEMENTS = (10_000, 1_000, MAX_ELEMENTS)  # Of an array, the first that fits _MAX_JSON.
_PART = re.compile(r"(\w+)((?:\[\d{1,9}\])*)")
_FIRST_BYTES = 16
_CHUNK = 50_000  # Elements that are compared at once, so that other threads get their turn.
_NOT_NUMBERS = ("boolean", "string", "wstring")


class _Form(NamedTuple):
    """The form of plain data."""

    elements: float = math.inf  # An array of more elements is described.
    is_json: bool = False  # Numbers that JSON lacks become texts.
    shortens: bool = False  # Long strings are cut.
    is_exact: bool = False  # A float32 keeps all its digits.
    keeps_bytes: bool = False  # The `ros2` command would take a number for a length.


_WHOLE, _JSON = _Form(is_exact=True), _Form(is_json=True)
_TEXT = _Form(elements=MAX_ELEMENTS, shortens=True)


def _plain(value: Any, kind: str, form: _Form) -> Any:
    """Return a value of a type as plain data: messages as mappings, arrays as lists."""
    element = element_of(kind)
    if element is not None:
        if len(value) > form.elements:
            return _description(value, element, form)
        return [_plain(item, element, form) for item in as_list(value)]
    if NESTED.fullmatch(kind):
        return _message(value, form)
    if isinstance(value, bytes) and form.keeps_bytes:
        return value
    if form.is_json and isinstance(value, float) and not math.isfinite(value):
        return str(value)
    shown = primitive(value, "" if form.is_exact else kind)
    return shortened(shown) if form.shortens and isinstance(shown, str) else shown


def _message(message: Any, form: _Form) -> dict[str, Any]:
    return {name: _plain(getattr(message, name), k, form) for name, k in kinds(message).items()}


def flat_fields(message: Any) -> Iterator[TypedField]:
    """Yield each field that is no message, by dotted path, with its value as plain data."""
    for field in leaves(message):
        yield field._replace(default=_plain(field.default, field.type, _WHOLE))


def as_yaml(message: Any) -> str:
    """Return a message in one line of YAML, as the `ros2` command takes it: `{pose: {x: 1.0}}`."""
    return flow(_message(message, _WHOLE._replace(keeps_bytes=True)))


def as_json(message: Any) -> dict[str, Any]:
    """Return a whole message as JSON has it; `nan` and `inf` are texts."""
    return _message(message, _JSON)


def one_line(message: Any) -> str:
    """Return every field and its value, safe to show, at most 500 characters: `x 1.5, name abc`."""
    values = ((field.path, _short(field.default, field.type)) for field in leaves(message))
    return harmless(", ".join(f"{path} {value}" for path, value in values if value))


def _short(value: Any, kind: str) -> str:
    element = element_of(kind)
    if element is not None:
        more = ", ..." if len(value) > MAX_ELEMENTS else ""
        items = ", ".join(_short(item, element) for item in as_list(value[:MAX_ELEMENTS]))
        return f"[{items}{more}]"
    if NESTED.fullmatch(kind):
        return f"{{{one_line(value)}}}"
    return f"{value:g}" if isinstance(value, float) else text_of(primitive(value, kind))


def find_field(message: Any, path: str) -> TypedField:
    """Return the field at a path such as `pose.x` or `ranges[3]`; else raise ArchoError."""
    value, kind, where = message, "", ""
    for part in path.split("."):
        found = _PART.fullmatch(part)
        known = kinds(value) if hasattr(value, "get_fields_and_field_types") else {}
        if found is None or found[1] not in known:
            names = f": {where or 'the message'} has {', '.join(known)}" if known else ""
            hint = nearest_hint(part.partition("[")[0], known) or names
            raise ArchoError(f"there is no field {safe(f'{where}.{part}'.lstrip('.'))}{hint}")
        value, kind = getattr(value, found[1]), known[found[1]]
        where = f"{where}.{found[1]}".lstrip(".")
        for index in map(int, re.findall(r"\d+", found[2])):
            element = element_of(kind)
            if element is None or index >= len(value):
                size = "is no array" if element is None else f"has {len(value)} elements"
                raise ArchoError(f"there is no {where}[{index}]: {where} {size}")
            kind, where = element, f"{where}[{index}]"
            value = as_list(value[index : index + 1])[0]
    return TypedField(path, kind, value)


def as_text(message: Any, paths: Sequence[str] = ()) -> str:
    """Return a message as YAML, as `ros2 topic echo` prints it, or chosen fields, one a line.

    Long arrays are described. Raises ArchoError if a field is unknown, or the text too long.
    """
    if paths:
        found = [find_field(message, path) for path in paths]
        text = "\n".join(f"{f.path}: {flow(_plain(f.default, f.type, _TEXT))}" for f in found)
    else:
        text = block(_message(message, _TEXT)).rstrip()
    lines = text.splitlines()
    if len(text) > _MAX_CHARACTERS:
        raise ArchoError(f"not shown: more than {_MAX_CHARACTERS // 1000} kB as text: name fields")
    if len(lines) > _MAX_LINES:
        lines[_MAX_LINES:] = [f"... and {len(lines) - _MAX_LINES} more lines: name fields"]
    return "\n".join(lines)


def as_data(message: Any, paths: Sequence[str] = ()) -> dict[str, Any]:
    """Return a message, or chosen fields by path, as data for at most 100,000 characters of JSON.

    Long arrays are described. Raises ArchoError if a field is unknown, or the JSON too long.
    """
    found = [find_field(message, path) for path in paths]
    for elements in _JSON_ELEMENTS:
        form = _Form(elements, is_json=True, shortens=elements == MAX_ELEMENTS)
        data: dict[str, Any] = (
            {f.path: _plain(f.default, f.type, form) for f in found}
            if paths
            else _message(message, form)
        )
        if len(json.dumps(data)) <= _MAX_JSON:
            return data
    raise ArchoError(f"not shown: more than {_MAX_JSON // 1000} kB as JSON: name fields")


def primitive(value: Any, kind: str) -> Any:
    """Return a bool, number or text as it is shown; a float32 becomes the shortest such number."""
    if isinstance(value, bytes):
        return value[0] if len(value) == 1 else value.hex(" ")
    return _shortest(value) if isinstance(value, float) and kind == "float" else value


def shortened(text: str) -> str:
    """Return a text, cut after 500 characters with ` ...` behind it."""
    return text if len(text) <= _MAX_TEXT else f"{text[:_MAX_TEXT]} ..."


def _shortest(value: float) -> float:
    """Return the number with the fewest digits that is the same float32: 0.1 for 0.10000000149."""
    for digits in range(6, 10):
        short = float(f"{value:.{digits}g}")
        if abs(short) < 3.4e38 and struct.pack("f", short) == struct.pack("f", value):
            return short
    return value


def _description(value: Any, element: str, form: _Form) -> Any:
    """Return type and length of a long array, and its range or its first bytes."""
    summary = summarize(value, element)
    found: dict[str, Any] = {"type": summary.type}
    if summary.first:
        found["first"] = summary.first
    if summary.least is not None:
        found["least"] = _plain(summary.least, element, form)
        found["greatest"] = _plain(summary.greatest, element, form)
    if summary.nan:
        found["nan"] = summary.nan
    if form.is_json:
        return found
    words = [found["type"]]
    if "least" in found:
        words.append(f"{found['least']} .. {found['greatest']}")
    if summary.nan:
        words.append(f"{summary.nan} nan")
    return ", ".join(words) + (f", {summary.first} ..." if summary.first else "")


class ArraySummary(NamedTuple):
    """A summary of an array, shown in place of its elements."""

    type: str  # With the length: `float32[360]`.
    length: int
    least: float | None = None  # None without a number; bytes have none, either.
    greatest: float | None = None
    nan: int = 0
    first: str = ""  # Of an array of bytes, the first 16 in hexadecimal.


def summarize(value: Any, element: str) -> ArraySummary:
    """Return the summary of an array, as rclpy has it, of elements of a type."""
    kind = f"{ros2msg_type(element)}[{len(value)}]"
    if element in ("uint8", "octet"):
        first = value[:_FIRST_BYTES]
        joined = b"".join(first) if element == "octet" else bytes(as_list(first))
        return ArraySummary(kind, len(value), first=joined.hex(" "))
    if NESTED.fullmatch(element) or element.partition("<")[0] in _NOT_NUMBERS:
        return ArraySummary(kind, len(value))
    ends: list[float] = []
    nan = 0
    for start in range(0, len(value), _CHUNK):
        chunk = as_list(value[start : start + _CHUNK])
        numbers = [number for number in chunk if number == number]
        nan += len(chunk) - len(numbers)
        ends += [min(numbers), max(numbers)] if numbers else []
    return ArraySummary(kind, len(value), min(ends, default=None), max(ends, default=None), nan)


def as_list(value: Any) -> list[Any]:
    """Return the elements of an array in a list; numbers of NumPy become Python's own."""
    found: list[Any] = value.tolist() if hasattr(value, "tolist") else list(value)
    return found
