"""The recorder of what a console did and showed, and the events that begin a recording.

What no topic of the robot tells is JSON on the topic `/archo_tui/state`: every field of a snapshot,
by its name, unless the robot file or the robot's messages tell it, and some of a view. All times
are Unix times. What is read is checked, since a file may hold anything.
"""

from __future__ import annotations

import asyncio
import json
import sys
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache, partial
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from builtin_interfaces.msg import Time
from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui import __version__
from archo_tui.base.clock import LAST_STAMP, Monotonic, UnixTime
from archo_tui.base.safe_text import harmless
from archo_tui.recordings.bag import LazyMessage
from archo_tui.recordings.recorder import BEGUN, BlackBox
from archo_tui.recordings.store import KEPT
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.audit_records import json_safe
from archo_tui.robot.state.events import OWN_LEVELS, Event
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.graph import LEVELS, Parameter
from archo_tui.robot.state.snapshot import Hosted, Snapshot
from archo_tui.robot_file.load import dump
from archo_tui.robot_file.model import GoalKind, RobotFile
from archo_tui.station.alarms import Alarm
from archo_tui.station.view import View

JOURNAL, STATE = "/archo_tui/journal", "/archo_tui/state"
_STOP = "STOP"
_EVENT_BYTES, _STATE_BYTES = 1000, 20_000  # That a waiting event or view takes, approximately.
_MAX_STATE_AGE = 10.0  # Seconds after which an unchanged state is recorded again.


class ConsoleRecorder:
    """The recorder of what the console did and showed, which also triggers recordings.

    `record_event` is called on the robot's thread, everything else on the event loop.
    """

    def __init__(self, box: BlackBox) -> None:
        self._box = box
        self._last_view: View | None = None
        self._last_key: tuple[object, ...] = ()
        self._state_time = 0.0  # Monotonic time of the last recorded state, in s.
        self.kept = ""  # The last recording on the disk that the operator asked for.

    @property
    def trouble(self) -> str:
        """A warning that recordings are not written or fill their budget; "" for none."""
        return self._box.trouble

    def record_event(self, event: Event) -> None:
        """Record an event that tells what a console did; the robot's own lines are on `/rosout`."""
        if event.level in OWN_LEVELS or event.source == "console":
            self._box.receive(JOURNAL, Log, LazyMessage(partial(_to_log, event), _EVENT_BYTES))

    def on_view(self, view: View, changed: Sequence[Alarm]) -> None:
        """Record a view of which more than readings changed; tick the black box, or trigger it."""
        key = change_key(view)
        if key != self._last_key or view.now - self._state_time > _MAX_STATE_AGE:
            self._last_key, self._state_time = key, view.now
            self._box.receive(STATE, String, LazyMessage(partial(_to_string, view), _STATE_BYTES))
        if self._last_view is not None:
            for why in reasons_to_record(self._last_view, view, changed):
                self._box.trigger(why)
        self._last_view = view
        self._box.tick()

    def keep(self, written: Callable[[Outcome], None] | None = None) -> Outcome:
        """Begin to record by hand; `written` gets the outcome on the event loop."""
        loop = None if written is None else asyncio.get_running_loop()

        def on_disk(name: str, failure: str) -> None:
            self.kept = name or self.kept
            outcome = Outcome(Code.DONE, f"recorded {name}")
            if failure:
                outcome = Outcome(Code.REFUSED, f"recording not written: {failure}")
            if loop is not None and written is not None:
                with suppress(RuntimeError):  # The loop is closed if the console has ended.
                    loop.call_soon_threadsafe(written, outcome)

        self._box.trigger(KEPT, by_hand=True, on_written=on_disk)
        return Outcome(Code.DONE, BEGUN)


def _to_log(event: Event, _first: bool, _since: float) -> Log:
    seconds, rest = divmod(int(event.time * 1e9), 10**9)
    return Log(
        stamp=Time(sec=min(seconds, LAST_STAMP), nanosec=rest),
        level=LEVELS.get(event.level, LEVELS["INFO"]),
        name=event.source,
        msg=f"{event.level}: {event.text}" if event.level in OWN_LEVELS else event.text,
        file=event.code,  # How it ended, as the journal says it.
        function=event.command,  # The `ros2` command line with the same effect.
    )


def _to_string(view: View, first: bool, since: float) -> String:
    return String(data=to_json(view, since, with_events=first))


def reasons_to_record(before: View, now: View, changed: Sequence[Alarm]) -> Iterator[str]:
    """Yield the reasons to begin or prolong a recording: STOPs, grave alarms, failed goals."""
    old, new = before.snapshot, now.snapshot
    # A stop that the robot reported from the beginning on is not new.
    stops_now = new.motion.stopped and old.motion.received is not None and not old.motion.stopped
    is_sent = new.open_stop is not None and old.open_stop is None
    if stops_now or is_sent or _has_new_stop_event(old, new):
        yield _STOP
    yield from (alarm.name for alarm in changed if alarm.is_urgent)
    known = max((goal.number for goal in old.history), default=0)
    for goal in reversed(new.history):
        if goal.number > known and _failed(goal):
            yield f"{goal.name}: {goal.word.lower()}"


def _has_new_stop_event(old: Snapshot, new: Snapshot) -> bool:
    if new.events is old.events:
        return False
    known = max((event.number for event in old.events), default=0)
    since = (event.audit_record for event in new.events if event.number > known)
    return any(record is not None and record.verb == "stop" for record in since)


def _failed(goal: Goal) -> bool:
    called_off = goal.phase == Phase.CANCELLED and goal.cancel_asked is not None
    return goal.started is not None and goal.phase != Phase.ARRIVED and not called_off


def attachments(robot: RobotFile) -> dict[str, str]:
    """Return the text of each attachment by its name: robot file, versions."""
    return {
        "robot.yaml": dump(robot),
        "versions.json": json.dumps({"archo-tui": __version__, "python": sys.version.split()[0]}),
    }


# Fields that a replay has from the robot file and from the robot's messages.
TOLD = frozenset(
    {"file", "forms", "battery", "motion", "pose", "diagnostics", "gauges", "transforms"}
)
_FIELDS = [name for name in Snapshot._fields if name not in TOLD]
# What changes all the time, or is compared by some of its fields only.
_VOLATILE = {"events", "charge", "message_rates", "nodes", "goal", "history"}
_STEADY = [name for name in _FIELDS if name not in _VOLATILE]
# The fields by which others are recorded; a replay has the rest from its robot file.
_SHORT: Mapping[type, Sequence[str]] = {
    Snapshot: _FIELDS,
    GoalKind: ("id", "title", "action", "type", "noun"),
    QueuedGoal: ("kind", "values"),
    Event: tuple(field.name for field in fields(Event) if field.name != "audit_record"),
}
_MAX_TIME = 1e11  # Unix time; a date much later cannot be shown.
_MAX_DEPTH = 4  # Of nested lists.
_NONE_TYPE = type(None)
_SCALARS = frozenset({str, int, bool, float})


class ConsoleState(NamedTuple):
    """The console's state at one moment: the fields of a view that no topic of the robot tells."""

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
    """Return a view's state, secrets masked; `since` is Unix minus monotonic time."""
    state = ConsoleState(*(getattr(view, name) for name in ConsoleState._fields))
    if not with_events:
        state = state._replace(snapshot=state.snapshot._replace(events=()))
    data = _to_data(state, ConsoleState, since)
    return json.dumps(data, ensure_ascii=False, separators=(",", ":"))


def from_json(text: str) -> ConsoleState:
    """Return the state that `to_json` wrote, safe for a terminal; it may raise anything."""
    return from_data(ConsoleState, json.loads(text))  # type: ignore[no-any-return]


def _to_data(value: Any, kind: Any, since: float) -> Any:
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
    if isinstance(data, str):
        return harmless(data)
    if isinstance(data, list) and depth < _MAX_DEPTH:
        return [_plain_value(part, depth + 1) for part in data]
    if data is None or isinstance(data, (bool, int, float)):
        return data
    raise TypeError("a number, a text or a list expected")
