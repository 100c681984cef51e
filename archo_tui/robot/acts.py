"""What a console did, as data: for its journal, and for the other consoles of the robot.

Each publishes it on TOPIC, in the robot's namespace, as one JSON object in a std_msgs/msg/String:

    {"console": "anna_lab_4711", "verb": "set", "code": "done",
     "arguments": {"node": "/motor_controller", "values": {"max_speed": 0.5}},
     "text": "set motor_controller max_speed 0.5: max_speed is 0.5, was 0.8"}

`text` is the line that people read, the same as on /rosout. Anybody can publish there, so nothing
follows from it but who did what, and what holds goals back: that a STOP came, holds, or is no
longer certain. Names that are not known are left alone. The number of TOPIC grows
when what a name means changes; a console of another number counts as one that publishes nothing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from archo_tui.robot.outcome import Code
from archo_tui.robot.text import harmless
from archo_tui.robot.values import text_of

TOPIC = "_archo_console/acts_1"  # hidden, as tools' are
LONGEST = 16_000  # characters of one that is read
_MOST = 100  # items of a list that are kept
_DEEPEST = 4  # values within values
_INT64 = 2**63


class Act(NamedTuple):
    """One verb that was carried out, or was not."""

    verb: str  # its id: stop, go, or one of the robot file's
    arguments: Mapping[str, Any]
    code: Code  # how it ended

    def bounded(self) -> Act:
        """The same with what JSON can hold, and safe texts of bounded length."""
        return Act(harmless(self.verb), bounded(self.arguments), self.code)


class Told(NamedTuple):
    """What another console says that it did."""

    console: str
    act: Act
    text: str


def write(console: str, act: Act, text: str) -> str:
    """The JSON object; of more values than are read their names alone."""
    verb, arguments, code = act.bounded()
    form = {"console": console, "verb": verb, "code": code.value, "text": text}
    whole = json.dumps({**form, "arguments": arguments})
    if len(whole) <= LONGEST:
        return whole
    names = {
        name: dict.fromkeys(value) if isinstance(value, Mapping) else value
        for name, value in arguments.items()
    }
    return json.dumps({**form, "arguments": names})


def read(form: str) -> Told | None:
    """What it says, or None for anything that is not of this form."""
    if len(form) > LONGEST:
        return None
    try:
        found = json.loads(form)
        console, verb, text = found["console"], found["verb"], found["text"]
        code, arguments = Code(found["code"]), found["arguments"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    texts = all(isinstance(said, str) for said in (console, verb, text))
    if not texts or not isinstance(arguments, dict):
        return None
    return Told(console, Act(verb, arguments, code), text)


def bounded(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values as JSON can hold them, and safe texts of bounded length."""
    return _mapping(values, 0)


def _mapping(values: Mapping[str, Any], depth: int) -> dict[str, Any]:
    return {harmless(str(name)): _plain(value, depth + 1) for name, value in values.items()}


def _plain(value: Any, depth: int) -> Any:
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int) and -_INT64 <= value < 2 * _INT64:
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    if isinstance(value, (Mapping, list, tuple)) and depth > _DEEPEST:
        return "..."
    if isinstance(value, Mapping):
        return _mapping(value, depth)
    if isinstance(value, (list, tuple)):
        return [_plain(item, depth + 1) for item in value[:_MOST]]
    return harmless(text_of(value))
