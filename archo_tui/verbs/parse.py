"""The parsing of words into the values of a verb, and the schema of values from programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from archo_tui.nearest import nearest_hint
from archo_tui.robot.messages.types import INTEGERS, element_of
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.station import Station
from archo_tui.verbs.base import Argument, Values, Verb, split_options

YES = "--yes"  # Answers a verb's question.
_TYPES = {"float": "number", "double": "number", "boolean": "boolean"}


class UnknownVerbError(ValueError):
    """The error for a word that is no verb; its text names the nearest verb, or `help`."""


def named(verbs: Mapping[str, Verb], word: str) -> Verb:
    """Return the verb with a word, which must be spelled exactly; raise UnknownVerbError."""
    if word in verbs:
        return verbs[word]
    hint = nearest_hint(word.lower(), verbs) or " (help lists them)"
    raise UnknownVerbError(f"no command {word!r}{hint}")


def parse(verb: Verb, station: Station, words: Sequence[str]) -> tuple[Values, bool]:
    """Parse the words after a verb into values, and True for `--yes`; ValueError has a hint.

    `--yes` may stand anywhere before `--`, if the verb may ask.
    """
    options, literal = split_options(words)
    yes = verb.may_ask and YES in options
    if yes:
        kept = [word for word in options if word != YES]
        words = [*kept, "--", *literal] if literal else kept
    try:
        return verb.values(words), yes
    except ValueError as error:
        raise ValueError(f"{error}{verb.hint(station, words)}") from None


def schema(verb: Verb, snapshot: Snapshot) -> dict[str, Any]:
    """Return the JSON Schema of a verb's values, as programs give them, or of one of many goals.

    Limits that are parameters of the robot have their present numbers, and are left out while they
    are not reported.
    """
    limit = snapshot.limit
    arguments = [a._replace(low=limit(a.low), high=limit(a.high)) for a in verb.arguments]
    return {
        "type": "object",
        "properties": {a.name.lstrip("-"): _schema_of(a) for a in arguments},
        "required": [a.name for a in verb.arguments if not (a.optional or a.is_flag)],
        "additionalProperties": False,
    }


def _schema_of(argument: Argument) -> dict[str, Any]:
    element = element_of(argument.type)
    if element is not None:
        return {"type": "array", "items": _schema_of(Argument(argument.name, element))}
    if argument.type in INTEGERS:
        low, high = INTEGERS[argument.type]
        found: dict[str, Any] = {"type": "integer", "minimum": low, "maximum": high}
    else:
        found = {"type": _TYPES.get(argument.type, "string")}
    if argument.low is not None:
        found["minimum"] = argument.low
    if argument.high is not None:
        found["maximum"] = argument.high
    return {**found, "description": f"in {argument.unit}"} if argument.unit else found
