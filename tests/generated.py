"""What documents and reserved.py have from the code, between two comments; the robot file's schema.

    python -m tests.generated

writes it; a test says when it is stale.
"""

from __future__ import annotations

import json
import re
import textwrap
import types
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, fields
from enum import Enum
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from archo_tui.cli.options import SUBCOMMANDS
from archo_tui.cli.verb import verbs_of_file
from archo_tui.robot.goals import machine as goals
from archo_tui.robot.state.goal import RUNNING, Phase
from archo_tui.robot.stop import machine as stop
from archo_tui.robot_file import model
from archo_tui.robot_file.load import NONE_WORDS, default_path, load
from archo_tui.screen.commands import registry
from archo_tui.screen.commands.base import NOT_TYPING, readable_key

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
SCHEMA = ROOT / "config" / "robots" / "schema.json"
_PART = re.compile(r"(<!-- made by python -m tests\.generated: (\w+) -->\n).*?(<!-- end -->)", re.S)
RESERVED = ROOT / "archo_tui" / "robot_file" / "reserved.py"
_WORDS = re.compile(r"(# made by python -m tests\.generated: words\n).*?(# end\n)", re.S)
# Of `--plain` alone; one that is to come; of a replay; of a panel that may come.
_FURTHER = ("help", "quit", "wait", "allow", "deny", "rewind", "time_line", "panel_9")
_TEXT, _NONE = {"$ref": "#/$defs/text"}, {"$ref": "#/$defs/none"}
_SCALARS: dict[Any, dict[str, Any]] = {
    str: _TEXT,
    float: {"type": "number"},
    int: {"type": "integer"},
    bool: {"type": "boolean"},
}

# where each record stands in a robot file
_PLACES: dict[Any, str] = {
    model.RobotFile: "The file",
    model.BatteryTopic: "`battery`",
    model.BatteryFields: "Each type of `battery`",
    model.MotionTopic: "`motion`",
    model.MotionFields: "Each type of `motion`",
    model.PoseTopic: "`pose`",
    model.PoseFields: "Each type of `pose`",
    model.GoalKind: "Each of `goals`",
    model.FormField: "Each field of a `form`",
    model.RemainingField: "`remaining` of a goal",
    model.StopServices: "`stop`",
    model.CommandService: "Each of `commands`",
    model.Gauge: "Each of `gauges`",
    model.Place: "Each of `places`",
    model.TopicRule: "Each of `topics`",
    model.FrameRule: "Each of `frames`",
    model.MessageField: "A reading",
    model.ParameterRef: "A number that is a parameter",
}


def schema() -> dict[str, Any]:
    """The JSON Schema of robot files, for editors; the console says more of what is wrong."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A robot file of archo-tui",
        **_record(model.RobotFile),
        "$defs": {
            **{kind.__name__: _record(kind) for kind in _PLACES if kind is not model.RobotFile},
            "text": {"type": ["string", "number", "boolean"]},  # it is taken as it is written
            "none": {"enum": [None, *filter(None, NONE_WORDS)]},
        },
    }


def _record(kind: Any) -> dict[str, Any]:
    hints, known = get_type_hints(kind, include_extras=True), _keys(kind)
    properties = {}
    for name, item in known.items():
        value, means = _told(hints[name])
        properties[name] = {"description": means, **_schema_of(value)}
        if value is str and not _is_needed(item):
            properties[name] = {"description": means, "anyOf": [_TEXT, _NONE]}
        if model.filled in hints[name].__metadata__:
            properties[name]["minProperties"] = 1
    return {
        "description": _summary(kind),
        "type": "object",
        "properties": properties,
        "required": [name for name, item in known.items() if _is_needed(item)],
        "additionalProperties": False,
    }


def _schema_of(kind: Any) -> dict[str, Any]:
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is Any:
        return {}
    if origin in (Union, types.UnionType):
        some = [_schema_of(one) for one in arguments if one is not type(None)]
        return {"anyOf": [*some, _NONE] if type(None) in arguments else some}
    if origin is Literal:
        return {"enum": [*arguments]}
    if origin is tuple:
        return {"type": "array", "items": _schema_of(arguments[0])}
    if origin is not None and issubclass(origin, Mapping):
        return {"type": "object", "additionalProperties": _schema_of(arguments[1])}
    if kind in _PLACES:
        record = {"$ref": f"#/$defs/{kind.__name__}"}
        return {"anyOf": [_TEXT, record]} if _shorthand(kind) else record
    return _SCALARS[kind]


def robot_file() -> str:
    """A table for each record of a robot file."""
    parts = []
    for kind, place in _PLACES.items():
        hints = get_type_hints(kind, include_extras=True)
        rows = ["| key | value | when left out | means |", "|---|---|---|---|"]
        for name, item in _keys(kind).items():
            value, means = _told(hints[name])
            rows.append(f"| `{name}` | {_words(value)} | {_default(item)} | {means} |")
        key = _shorthand(kind)
        short = f" `{key}` alone may be written in its place." if key else ""
        parts.append("\n".join((f"### {place}", "", f"{_summary(kind)}{short}", "", *rows, "")))
    return "\n".join(parts)


def _told(hint: Any) -> tuple[Any, str]:
    """The type of a key, and what it means."""
    assert get_origin(hint) is Annotated, "say in the model what it means: Annotated[type, meaning]"
    return hint.__origin__, hint.__metadata__[0]


def _keys(kind: Any) -> dict[str, Field[Any]]:
    return {item.name: item for item in fields(kind) if item.name != "where"}


def _is_needed(item: Field[Any]) -> bool:
    return item.default is MISSING and item.default_factory is MISSING


def _shorthand(kind: Any) -> str:
    """The key whose text may stand for the whole record; empty: none may."""
    needed = [name for name, item in _keys(kind).items() if _is_needed(item)]
    return needed[0] if len(needed) == 1 and get_type_hints(kind)[needed[0]] is str else ""


def _summary(kind: Any) -> str:
    return " ".join(str(kind.__doc__).partition("\n\n")[0].split())


def _words(kind: Any) -> str:
    """What a value is, in words; a link where that has a table of its own."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is Any:
        return "any value"
    if origin in (Union, types.UnionType):
        some = [one for one in arguments if one is not type(None)]
        return "single value" if {*some} == {*_SCALARS} else " or ".join(map(_words, some))
    if origin is Literal:
        return ", ".join(f"`{word}`" for word in arguments)
    if origin is tuple:
        return f"a list: {_words(arguments[0])}"
    if origin is not None and issubclass(origin, Mapping):
        return f"by name: {_words(arguments[1])}"
    if kind in _PLACES:
        title = _PLACES[kind]
        return f"[{title.replace('`', '')}](#{anchor(title)})"
    return {str: "text", float: "number", int: "whole number", bool: "`true`, `false`"}[kind]


def _default(item: Field[Any]) -> str:
    if _is_needed(item):
        return "**needed**"
    value = "" if item.default is MISSING else item.default
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f"`{value:g}`" if isinstance(value, float) else f"`{value}`" if value else ""


def anchor(heading: str) -> str:
    """As GitHub makes it of a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def keys() -> str:
    """The registry's keys."""
    rows = ["| key | does | works |", "|---|---|---|"]
    for command in registry(load(default_path())):
        if command.id.startswith("panel_"):
            if command.id == "panel_1":
                numbers = [
                    c.key for c in registry(load(default_path())) if c.id.startswith("panel_")
                ]
                rows.append(f"| `1` .. `{numbers[-1]}`, tab | go to a panel | {NOT_TYPING} |")
            continue
        does = command.help
        if does[1].islower():
            does = does[0].lower() + does[1:]
        key = readable_key(command.key).replace("^", "ctrl+")
        key = f"`{key}`" if key else "palette"
        rows.append(f"| {key} | {does} | {command.where_text} |")
    leaves = "leave a field, a dialog or the full screen; clear a filter"
    return "\n".join((*rows, f"| esc | {leaves} | everywhere |", ""))


def words() -> str:
    """ARCHO's verbs."""
    rows = ["| verb | does |", "|---|---|"]
    for verb in verbs_of_file().values():
        rows.append(f"| `{f'{verb.id} {verb.usage}'.rstrip()}` | {verb.help} |")
    return "\n".join((*rows, ""))


_MOVING, _UNKNOWN, _LOST = Phase.MOVING, Phase.UNKNOWN, Phase.LOST


def stop_table() -> str:
    """LATCH, a row an event."""
    return _table(stop, stop.LATCH, [*stop.State])


def goal_table() -> str:
    """PHASES, a row an event."""
    table = {
        event: [before if to is None else to for before, to in zip(RUNNING, phases, strict=True)]
        for event, phases in goals.PHASES.items()
    }
    # A cancel that failed returns to the phase before it; nothing else is not a phase.
    text = _table(goals, table, [*RUNNING])
    row = next(line for line in text.splitlines() if line.startswith("| `CANCEL_FAILED`"))
    cells = row.split("|")
    cells[3 + RUNNING.index(Phase.CANCELLING)] = " the phase before "
    return text.replace(row, "|".join(cells))


def _table(machine: ModuleType, table: Mapping[Any, Sequence[Any]], states: Sequence[Enum]) -> str:
    source = Path(str(machine.__file__)).read_text(encoding="utf-8")
    events = source.partition("class Event(")[2].partition("class ")[0]
    said = dict(re.findall(r"^    (\w+) = auto\(\)  # (.*)$", events, re.M))
    heads = " | ".join(state.name for state in states)
    rows = [f"| event | what has happened | {heads} |", f"|---|---|{'---|' * len(states)}"]
    for event, afters in table.items():
        cells = [
            "-" if to is None else "" if to is before else to.name
            for before, to in zip(states, afters, strict=True)
        ]
        rows.append(f"| `{event.name}` | {said[event.name]} | {' | '.join(cells)} |")
    return "\n".join((*rows, ""))


def stop_picture() -> str:
    """The states of a STOP, as Mermaid draws them."""
    found: dict[tuple[str, str], list[str]] = {}
    for event, states in stop.LATCH.items():
        for before, to in zip(stop.State, states, strict=True):
            if to is not None and before is not to:
                found.setdefault((before.name, to.name), []).append(event.name)
    return _mermaid(found)


def goal_picture() -> str:
    """The phases of a goal, as Mermaid draws them; all ends are one."""
    found: dict[tuple[str, str], list[str]] = {}
    for event, phases in goals.PHASES.items():
        for before, to in zip(RUNNING, phases, strict=True):
            for after in [_MOVING, _UNKNOWN, _LOST] if to is None else [to]:
                if before is not after:
                    end = after.name if after in RUNNING else "[*]"
                    found.setdefault((before.name, end), []).append(event.name)
    always = {event.name for event, phases in goals.PHASES.items() if phases[0] not in RUNNING}
    always -= {goals.Event.REFUSED.name}
    for step, names in found.items():
        if step[1] == "[*]":
            found[step] = [*(name for name in names if name not in always), "its end"]
    return _mermaid(found)


def _mermaid(steps: Mapping[tuple[str, str], Sequence[str]]) -> str:
    rows = [f"    {a} --> {b}: {', '.join(names)}" for (a, b), names in sorted(steps.items())]
    return "\n".join(("```mermaid", "stateDiagram-v2", *rows, "```", ""))


_PARTS = {
    "robot_file": robot_file,
    "keys": keys,
    "verbs": words,
    "stop_table": stop_table,
    "goal_table": goal_table,
    "stop_picture": stop_picture,
    "goal_picture": goal_picture,
}


def reserved() -> str:
    """The console's own words, of verbs in the order of help."""
    robot = load(default_path())
    given = {word for command in robot.commands for word in (command.id, command.off_word)}
    verbs = [verb for verb in verbs_of_file() if verb not in given]
    others = {*_FURTHER, *SUBCOMMANDS, *(command.id for command in registry(model.RobotFile()))}
    lists = {"VERBS": verbs, "_OTHERS": sorted(others - {*verbs})}
    return "".join(f"{name} = (\n{_rows(words)})\n" for name, words in lists.items())


def _rows(words: Sequence[str]) -> str:
    filled = textwrap.wrap(", ".join(f'"{word}"' for word in words), 90)
    return "".join(f"    *({row.removesuffix(',')}),\n" for row in filled)


def files() -> dict[Path, str]:
    """The text that each file with such a part should have."""

    def part(found: re.Match[str]) -> str:
        return f"{found[1]}\n{_PARTS[found[2]]()}\n{found[3]}"

    pages = {page: page.read_text(encoding="utf-8") for page in DOCS.glob("*.md")}
    made = {page: _PART.sub(part, text) for page, text in pages.items() if _PART.search(text)}
    code = RESERVED.read_text(encoding="utf-8")
    made[RESERVED] = _WORDS.sub(lambda found: f"{found[1]}{reserved()}{found[2]}", code)
    return made | {SCHEMA: json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"}


if __name__ == "__main__":
    for path, text in files().items():
        path.write_text(text, encoding="utf-8")
