"""The arguments of a tool: schemas for models, and the check of what a model gives."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from archo_tui.safe_text import harmless

MAX_TEXT = 200  # Characters.
MAX_OBJECT = 4096  # Bytes as JSON.
_SHOWN = 40  # Characters of a value that an error quotes.
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


class InvalidArguments(Exception):
    """The error for arguments that do not fit the schema; its message is one line."""


def schema_of(properties: Mapping[str, Any], required: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return the JSON schema of a tool that takes these properties and no others."""
    return {
        "type": "object",
        "properties": dict(properties),
        "required": list(required),
        "additionalProperties": False,
    }


def check_arguments(schema: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    """Check arguments, of an object only the size, against a schema; raise InvalidArguments."""
    known = schema["properties"]
    if schema["additionalProperties"]:  # Only STOP's schema: its arguments are ignored.
        return
    for name in given:
        if name not in known:
            takes = ", ".join(known) or "no arguments"
            raise InvalidArguments(f"unknown argument {shorten(name)}: this tool takes {takes}")
    for name in schema["required"]:
        if name not in given:
            raise InvalidArguments(f"{name} is missing: {known[name]['description']}")
    for name, value in given.items():
        fault = _fault(value, known[name])
        if fault:
            raise InvalidArguments(f"{name}: {fault}")


def _fault(value: Any, schema: Mapping[str, Any]) -> str:
    kind = schema["type"]
    if isinstance(value, bool) or not isinstance(value, _TYPES[kind]):
        return f"expected {_NAMES[kind]}, not {shorten(value)}"
    if isinstance(value, dict):
        return _fault_of_object(value)
    if isinstance(value, str) and len(value) > MAX_TEXT:
        return f"at most {MAX_TEXT} characters, not {len(value)}"
    if "enum" in schema and value not in schema["enum"]:
        return f"one of {', '.join(map(str, schema['enum']))}, not {shorten(value)}"
    low, high = schema.get("minimum"), schema.get("maximum")
    # Written so that NaN, for which comparisons are false, is refused.
    if (low is not None and not value >= low) or (high is not None and not value <= high):
        return f"{low} to {high}, not {shorten(value)}"
    return ""


def _fault_of_object(value: dict[str, Any]) -> str:
    try:
        size = len(json.dumps(value, allow_nan=False).encode("utf-8"))
    except (ValueError, TypeError, RecursionError):
        return "a number in it is too large or not finite, or it is too deep"
    return f"at most {MAX_OBJECT} bytes of JSON, not {size}" if size > MAX_OBJECT else ""


def shorten(value: Any) -> str:
    """Return a value on one line, harmless to print and cut to 40 characters, for an error."""
    if isinstance(value, (dict, list)):
        return "an object" if isinstance(value, dict) else "a list"
    if isinstance(value, int) and value.bit_length() > 64:
        return "a number of that size"
    text = repr(value[:_SHOWN]) if isinstance(value, str) else json.dumps(value)
    cut = isinstance(value, str) and len(value) > _SHOWN
    return harmless(f"{text} ..." if cut else text)
