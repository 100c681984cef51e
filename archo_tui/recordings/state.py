"""The state of the console in a recording: JSON on the topic `/archo_tui/state`.

It holds every field of a snapshot, by its name, unless the robot file or the robot's messages tell
it, and some of a view. All times are Unix times. What is read is checked, since a file may hold
anything.
"""

from __future__ import annotations

import json
import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from archo_tui.clock import Monotonic, UnixTime
from archo_tui.robot.audit_records import json_safe
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.state import Event, Hosted, Parameter, Snapshot
from archo_tui.robot_file.model import GoalKind
from archo_tui.safe_text import harmless
from archo_tui.station.alarms import Alarm
from archo_tui.station.view import View

# Fields that a replay has from the robot file and from the robot's messages.
TOLD = frozenset({"file", "forms", "battery", "motion", "pose", "diagnostics", "gauges"})
_FIELDS = [name for name in Snapshot._fields if name not in TOLD]
# What changes all the time, or is compared by some of its fields only.
_VOLATILE = {"events", "charge", "message_rates", "nodes", "goal", "history"}
_STEADY = [name for name in _FIELDS if name not in _VOLATILE]
# The fields by which others are recorded; a replay has the rest from its robot file.
_SHORT: Mapping[type, tuple[str, ...]] = {
    GoalKind: ("id", "title", "action", "type", "noun"),
    QueuedGoal: ("kind", "values"),
    Event: tuple(field.name for field in fields(Event) if field.name != "audit_record"),
}
_MAX_TIME = 1e11  # Unix time; a date much later cannot be shown.
_MAX_DEPTH = 4  # Of nested lists.
_NONE_TYPE = type(None)
_SCALARS = frozenset({str, int, bool, float})


class ConsoleState(NamedTuple):
    """The console's state at one moment: what no topic of the robot tells.

    But for the snapshot, the fields are those of a view.
    """

    snapshot: Snapshot = Snapshot()
    engine: str = ""
    hosted: tuple[Hosted, ...] = ()
    alarms: tuple[Alarm, ...] = ()
    queue: tuple[QueuedGoal, ...] = ()
    held: str = ""
    clients: tuple[str, ...] = ()


def change_key(view: View) -> tuple[object, ...]:
    """Return a tuple that differs from an earlier view's if this one is worth recording again."""
    snapshot, goal = view.snapshot, view.snapshot.goal
    return (
        *[getattr(snapshot, name) for name in _STEADY],
        tuple([(node.name, node.lifecycle) for node in snapshot.nodes]),
        None if goal is None else (goal.number, goal.phase, goal.length, goal.message),
        tuple([ended.number for ended in snapshot.history]),
        tuple([(alarm.name, alarm.state, alarm.reason) for alarm in view.alarms]),
        *(view.hosted, view.waiting, view.held, view.clients),
    )


def to_json(view: View, since: float, *, with_events: bool) -> str:
    """Return a view's state, secrets masked; `since` is Unix minus monotonic time.

    The events so far are in the first state of a recording only.
    """
    snapshot = view.snapshot if with_events else view.snapshot._replace(events=())
    hints = {**_type_hints(ConsoleState), **_type_hints(Snapshot)}
    values = {name: getattr(view, name) for name in ConsoleState._fields if name != "snapshot"}
    values |= {name: getattr(snapshot, name) for name in _FIELDS}
    data = {name: _to_data(value, hints[name], since) for name, value in values.items()}
    return json.dumps(data, ensure_ascii=False, separators=(",", ":"))


def from_json(text: str) -> ConsoleState:
    """Return the state that `to_json` wrote; a hostile text may raise anything.

    Missing fields get their defaults, unknown ones are ignored. Texts become safe for a terminal.
    """
    data = _require_type(dict, json.loads(text))
    told = {name: data[name] for name in _FIELDS if name in data}
    return from_data(ConsoleState, {**data, "snapshot": told})  # type: ignore[no-any-return]


def _to_data(value: Any, kind: Any, since: float) -> Any:
    """Return a value of a type as JSON has it; `from_data` is the way back."""
    if value is None or isinstance(value, (str, bool)):
        return value
    origin, inner = _origin_and_args(kind)
    if origin in (Union, types.UnionType):
        return _to_data(value, next(k for k in inner if k is not _NONE_TYPE), since)
    if kind == Monotonic:
        return value + since
    if origin is Annotated:
        return _to_data(value, inner[0], since)
    if origin is tuple and inner[-1] is Ellipsis:
        return [_to_data(part, inner[0], since) for part in value]
    if origin is tuple:
        return [_to_data(part, kind, since) for part, kind in zip(value, inner, strict=True)]
    if origin is frozenset:
        return sorted(value)
    if origin is not None and issubclass(origin, Mapping):
        return {str(name): _to_data(part, inner[1], since) for name, part in value.items()}
    if isinstance(value, Enum):
        return value.name
    if hasattr(kind, "_fields") or is_dataclass(kind):
        given = value.masked if isinstance(value, Parameter) else value
        hints = _type_hints(kind)
        names = _SHORT.get(kind, hints)
        return {name: _to_data(getattr(given, name), hints[name], since) for name in names}
    if isinstance(value, (list, tuple)):  # Of a field of any type.
        return [_to_data(part, Any, since) for part in value]
    # NaN, infinity and integers beyond 64 bits become texts, which are refused for a number.
    return json_safe({"": value})[""]


def from_data(kind: Any, data: Any) -> Any:
    """Build a value of a type from JSON data, or raise TypeError, ValueError or KeyError."""
    if kind in _SCALARS:
        return _scalar_value(kind, data)
    if kind is Any:
        return _plain_value(data, 0)
    origin, inner = _origin_and_args(kind)
    if origin in (Union, types.UnionType):
        wanted = next(k for k in inner if k is not _NONE_TYPE)
        return None if data is None else from_data(wanted, data)
    if kind in (Monotonic, UnixTime) and not 0 <= _scalar_value(float, data) < _MAX_TIME:
        raise ValueError("a time that has no date")
    if origin is Annotated:
        return from_data(inner[0], data)
    if origin is tuple and inner[-1] is Ellipsis:
        return tuple([from_data(inner[0], part) for part in _require_type(list, data)])
    if origin is tuple:
        pairs = zip(inner, _require_type(list, data), strict=True)
        return tuple([from_data(*pair) for pair in pairs])
    if origin is frozenset:
        return frozenset([from_data(inner[0], part) for part in _require_type(list, data)])
    if origin is not None and issubclass(origin, Mapping):
        items = _require_type(dict, data).items()
        return {harmless(name): from_data(inner[1], part) for name, part in items}
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind[_require_type(str, data)]
    hints, given = _type_hints(kind), _require_type(dict, data)
    names = [name for name in _SHORT.get(kind, hints) if name in given]
    return kind(**{name: from_data(hints[name], given[name]) for name in names})


@lru_cache
def _origin_and_args(kind: Any) -> tuple[Any, tuple[Any, ...]]:
    return get_origin(kind), get_args(kind)


@lru_cache
def _type_hints(kind: Any) -> Mapping[str, Any]:
    return get_type_hints(kind, include_extras=True)


def _scalar_value(kind: type, data: Any) -> Any:
    if kind is float and isinstance(data, int) and not isinstance(data, bool):
        return float(data)
    found = _require_type(kind, data)
    return harmless(found) if kind is str else found


def _require_type(kind: type, data: Any) -> Any:
    if type(data) is not kind:
        raise TypeError(f"{kind.__name__} expected")
    return data


def _plain_value(data: Any, depth: int) -> Any:
    """Return None, a number, a text, or lists of them; raise TypeError for anything else."""
    if isinstance(data, str):
        return harmless(data)
    if isinstance(data, list) and depth < _MAX_DEPTH:
        return [_plain_value(part, depth + 1) for part in data]
    if data is None or isinstance(data, (bool, int, float)):
        return data
    raise TypeError("a number, a text or a list expected")
