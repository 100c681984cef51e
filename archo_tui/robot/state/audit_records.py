"""The audit records of what consoles did: for the journal, and for the robot's other consoles.

Each console publishes its records on TOPIC, in the robot's namespace. A record is one JSON object
in a std_msgs/msg/String:

    {"console": "anna_lab_4711", "verb": "set", "code": "done",
     "arguments": {"node": "/motor_controller", "values": {"max_speed": 0.5}},
     "text": "set motor_controller max_speed 0.5: max_speed is 0.5, was 0.8"}

`text` is the line that people read, the same as on /rosout. Any node can publish on TOPIC. So a
record may only tell who did what, and hold goals back: a STOP came, holds, or is no longer certain.
Unknown names in the object are ignored. The number in TOPIC grows when the meaning of a name
changes; a console with another number counts as one that publishes nothing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from archo_tui.base.safe_text import harmless
from archo_tui.robot.messages.values import fits_an_integer, text_of
from archo_tui.robot.outcome import Code

TOPIC = "_archo_console/acts_1"  # A hidden name, as ROS tools use.
MAX_LENGTH = 16_000  # Characters of a record; a longer one is ignored.
_MAX_ITEMS = 100  # Items of a list that are kept.
_MAX_DEPTH = 4  # Levels of nested values that are kept.


class AuditRecord(NamedTuple):
    """The record of a verb that was carried out, or was refused."""

    # The id of the verb, such as `stop`, `go`, `set`, or that of a command in the robot file.
    verb: str
    arguments: Mapping[str, Any]  # The values of the verb's arguments, by their names.
    code: Code  # How the verb ended.

    def json_safe(self) -> AuditRecord:
        """Return a copy whose texts are safe to show, with arguments that JSON can hold."""
        return AuditRecord(harmless(self.verb), json_safe(self.arguments), self.code)


class PublishedRecord(NamedTuple):
    """A record that a console published."""

    console: str  # The name of the console, as it says itself.
    record: AuditRecord
    text: str  # The line for people; it may hold any characters.


def to_json(console: str, record: AuditRecord, text: str) -> str:
    """Return a record as one JSON object, in the form of this module; nothing is sent."""
    verb, arguments, code = record.json_safe()
    form = {"console": console, "verb": verb, "code": code.value, "text": text}
    for kept in (arguments, _without_contents(arguments)):
        as_json = json.dumps({**form, "arguments": kept})
        if len(as_json) <= MAX_LENGTH:
            return as_json
    return json.dumps({**form, "arguments": {}})


def _without_contents(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments with null for lists, and for the values of mappings."""
    lists = {name: None for name, value in arguments.items() if isinstance(value, list)}
    mappings = {
        name: dict.fromkeys(value)
        for name, value in arguments.items()
        if isinstance(value, Mapping)
    }
    return {**arguments, **lists, **mappings}


def parse(form: str) -> PublishedRecord | None:
    """Return the record in a JSON text, not made safe; None if it is no record, or too long."""
    if len(form) > MAX_LENGTH:
        return None
    try:
        found = json.loads(form)
        console, verb, text = found["console"], found["verb"], found["text"]
        code, arguments = Code(found["code"]), found["arguments"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    are_texts = all(isinstance(item, str) for item in (console, verb, text))
    if not are_texts or not isinstance(arguments, dict):
        return None
    return PublishedRecord(console, AuditRecord(verb, arguments, code), text)


def json_safe(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of values that JSON can hold, with texts that are safe to show."""
    return _mapping(values, 0)


def _mapping(values: Mapping[str, Any], depth: int) -> dict[str, Any]:
    return {harmless(str(name)): _plain(value, depth + 1) for name, value in values.items()}


def _plain(value: Any, depth: int) -> Any:
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int) and fits_an_integer(value):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    if isinstance(value, (Mapping, list, tuple)) and depth > _MAX_DEPTH:
        return "..."
    if isinstance(value, Mapping):
        return _mapping(value, depth)
    if isinstance(value, (list, tuple)):
        return [_plain(item, depth + 1) for item in value[:_MAX_ITEMS]]
    return harmless(text_of(value))
