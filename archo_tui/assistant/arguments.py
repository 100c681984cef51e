"""The arguments of a tool: one schema says what a model may give, and checks what it gave."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from archo_tui.robot.text import harmless

LONGEST = 200  # characters of a text
LARGEST = 4096  # bytes of an object, as JSON
_SHOWN = 40  # characters of what was given, in the line that says what is wrong
_TYPES: dict[str, tuple[type, ...]] = {
    "string": (str,),
    "integer": (int,),
    "number": (int, float),
    "object": (dict,),
}
_NAMES = {
    "string": "a text",
    "integer": "a whole number",
    "number": "a number",
    "object": "an object",
}


class Misuse(Exception):
    """The arguments cannot be meant; one line says why."""


def schema_of(properties: Mapping[str, Any], required: tuple[str, ...] = ()) -> dict[str, Any]:
    """The schema of a tool's arguments; nothing else may be given."""
    return {
        "type": "object",
        "properties": dict(properties),
        "required": list(required),
        "additionalProperties": False,
    }


def check(schema: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    """Raises Misuse, with one line.

    Of an object its size is checked and nothing else: what may be in it the console knows.
    """
    known = schema["properties"]
    if schema["additionalProperties"]:  # of STOP: whatever it is, it is ignored
        return
    for name in given:
        if name not in known:
            takes = ", ".join(known) or "no arguments"
            raise Misuse(f"unknown argument {shown(name)}: this tool takes {takes}")
    for name in schema["required"]:
        if name not in given:
            raise Misuse(f"{name} is missing: {known[name]['description']}")
    for name, value in given.items():
        fault = _fault(value, known[name])
        if fault:
            raise Misuse(f"{name}: {fault}")


def _fault(value: Any, schema: Mapping[str, Any]) -> str:
    kind = schema["type"]
    if isinstance(value, bool) or not isinstance(value, _TYPES[kind]):
        return f"expected {_NAMES[kind]}, not {shown(value)}"
    if isinstance(value, dict):
        return _fault_of_object(value)
    if isinstance(value, str) and len(value) > LONGEST:
        return f"at most {LONGEST} characters, not {len(value)}"
    if "enum" in schema and value not in schema["enum"]:
        return f"one of {', '.join(map(str, schema['enum']))}, not {shown(value)}"
    low, high = schema.get("minimum"), schema.get("maximum")
    # the comparisons are false for NaN
    if (low is not None and not value >= low) or (high is not None and not value <= high):
        return f"{low} to {high}, not {shown(value)}"
    return ""


def _fault_of_object(value: dict[str, Any]) -> str:
    try:
        size = len(json.dumps(value, allow_nan=False).encode("utf-8"))
    except (ValueError, TypeError, RecursionError):
        return "a number in it is too large or not finite, or it is too deep"
    return f"at most {LARGEST} bytes of JSON, not {size}" if size > LARGEST else ""


def shown(value: Any) -> str:
    """The beginning of what was given, which may be of any size."""
    if isinstance(value, (dict, list)):
        return "an object" if isinstance(value, dict) else "a list"
    if isinstance(value, int) and value.bit_length() > 64:
        return "a number of that size"
    text = repr(value[:_SHOWN]) if isinstance(value, str) else json.dumps(value)
    cut = isinstance(value, str) and len(value) > _SHOWN
    return harmless(f"{text} ..." if cut else text)
