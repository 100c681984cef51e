"""The dataclasses of a robot file: the topics, actions and services that the console uses.

Everything is optional: a robot that lacks something leaves it out, and the screen shows it greyed.
`where` holds `FILE:LINE`, for messages about that entry. The text beside each type is its
documentation: `python -m tests.generated` makes docs/own_robot.md and config/robots/schema.json of
it. Behind it may stand a check: it returns what is wrong with a value, in words that follow the
key's name, or "". What concerns several keys is checked by a class's `faults`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, TypeVar

from archo_tui.robot_file.reserved import RESERVED
from archo_tui.ros.names import is_name, parse_type

NO_STOP = "has no STOP: use the hardware stop"  # Said of a robot whose file names no stop service.

DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"

Scalar = bool | int | float | str


Faults = Iterator[tuple[str, str]]  # Where (`FILE:LINE`; "" for the whole entry), and what.


def _where() -> Any:
    return field(default="", compare=False, repr=False)


# The checks of single values.

Check = Callable[[Any], str]
_ID = re.compile(r"[a-z][a-z0-9_]*")
_PLACE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")
_NO_PLACES = {"nan", "inf", "infinity", "true", "false", "yes", "no", "on", "off", "null"}


def is_place_name(text: str) -> bool:
    """Return True for a name that cannot be taken for a value: letters, digits, `_` and `-`."""
    return _PLACE_NAME.fullmatch(text) is not None and text.lower() not in _NO_PLACES


def filled(value: Any) -> str:
    """Check that something is given."""
    return "" if value else "is empty: expected lines like 'name: value'"


def _title(text: str) -> str:
    return "" if text.strip() else "is empty: say what it is in a word or two"


def _name(text: str) -> str:
    return "" if is_name(text) else f"{text!r} is not a name of a topic, service or action"


def _names(texts: Iterable[str]) -> str:
    return next(filter(None, map(_name, texts)), "")


def _place(text: str) -> str:
    return "" if is_place_name(text) else f"{text!r} is no name: a letter, then letters and digits"


def _type(kind: Literal["msg", "action"]) -> Check:
    def check(text: str) -> str:
        parts = parse_type(text)
        is_one = parts is not None and parts.kind == kind
        return "" if is_one else f"{text!r} is not a type: expected package/{kind}/Name"

    return check


_MESSAGE, _ACTION = _type("msg"), _type("action")


def _types(by_type: Mapping[str, Any]) -> str:
    if not by_type:
        return "is empty: name the type of the topic"
    return next(filter(None, map(_MESSAGE, by_type)), "")


def _number(is_right: Callable[[float], bool], rule: str) -> Check:
    def check(limit: Limit) -> str:
        value = known_number(limit)
        return "" if value is None or is_right(value) else f"is {value:g}: {rule}"

    return check


_PERIOD = _number(lambda value: value > 0, "a time in s, above 0")
_CHARGE = _number(lambda value: 0 <= value <= 100, "a charge is within 0 .. 100")
_LENGTH = _number(lambda value: value > 0, "a length is above 0")
_RATE = _number(lambda value: 0 < value <= 1000, "more than 0, at most 1000 Hz")
_SHARE = _number(lambda value: 0 < value < 1, "a share is more than 0, less than 1")
_SCALE = _number(lambda value: value != 0, "every reading would be the same")
_SIZE = _number(lambda value: value >= 0, "it must not be negative")


def _order(name: str, low: Limit, other: str, high: Limit, where: str = "") -> Faults:
    least, most = known_number(low), known_number(high)
    if least is not None and most is not None and least > most:
        yield where, f"{name} {least:g} is above {other} {most:g}: swap them"


def _duplicates(entries: Iterable[tuple[str, str, str]]) -> Faults:
    used = set()
    for where, what, word in entries:
        if word in used:
            yield where, f"duplicate {what} {word}: choose another"
        used.add(word)


# What several entries have.
T = TypeVar("T")
TopicName = Annotated[str, "the topic's name", _name]
FieldsByType = Annotated[
    Mapping[str, T], "the fields, by message type; a topic of another type is not used", _types
]
Period = Annotated[float | None, "s between two messages; measured when left out", _PERIOD]


# The entries.


@dataclass(frozen=True)
class MessageField:
    """The field of a message that holds a reading, and how to convert its value."""

    field: Annotated[str, "its dotted path in the message"]
    scale: Annotated[float, "factor that makes it a value of the unit", _SCALE] = 1.0
    offset: Annotated[float, "added after scaling"] = 0.0
    equals: Annotated[Scalar | None, "true when the value is this"] = None
    beyond: Annotated[float | None, "true when the value's size is larger", _SIZE] = None
    unit: Annotated[str, "what is shown behind it"] = ""
    where: str = _where()

    def faults(self) -> Faults:
        if self.equals is not None and self.beyond is not None:
            yield "", "equals and beyond exclude each other: give one of them"


def fields_of(given: MessageField | tuple[MessageField, ...] | None) -> tuple[MessageField, ...]:
    """Return the message fields that a reading consists of; () if it is left out."""
    if given is None:
        return ()
    return given if isinstance(given, tuple) else (given,)


@dataclass(frozen=True)
class ParameterRef:
    """A number that a node of the robot holds as a parameter."""

    node: Annotated[str, "the node's name; one that begins with `/` is not of `--namespace`"]
    parameter: Annotated[str, "the parameter's name"]
    otherwise: Annotated[float | None, "the number while the node does not report it"] = None
    where: str = _where()


Limit = float | ParameterRef | None  # None: the value has no limit.


def known_number(limit: Limit) -> float | None:
    """Return the number of a limit without the robot's parameters; None if there is none."""
    return limit.otherwise if isinstance(limit, ParameterRef) else limit


@dataclass(frozen=True)
class BatteryFields:
    """The fields of one message type about the battery."""

    percentage: Annotated[MessageField, "the charge: 0 .. 100 %"]
    voltage: Annotated[MessageField | None, "V"] = None
    charging: Annotated[MessageField | None, "true while it charges"] = None
    discharging: Annotated[
        MessageField | None, "true while it discharges; left out: whenever it does not charge"
    ] = None
    health: Annotated[
        MessageField | None, "the battery's own word; what it means is in `health`"
    ] = None


@dataclass(frozen=True)
class MotionFields:
    """The fields of one message type about the motion."""

    count: Annotated[MessageField | None, "a whole number that is counted: encoder ticks"] = None
    speed: Annotated[MessageField | None, "the speed, in its own unit"] = None
    moving: Annotated[
        MessageField | tuple[MessageField, ...] | None,
        "true while it moves; of several readings while one of them is true",
        lambda given: "is empty: name a reading, or leave it out" if given == () else "",
    ] = None
    stopped: Annotated[MessageField | None, "true while the software stop is latched"] = None


@dataclass(frozen=True)
class BatteryTopic:
    """The topic that reports the charge."""

    topic: TopicName
    types: FieldsByType[BatteryFields]
    low: Annotated[
        Limit,
        "%; a charge below it is low; or a parameter: `{node, parameter, otherwise}`",
        _CHARGE,
    ] = None
    health: Annotated[
        Mapping[str, Literal["good", "low", "replace"]], "what the battery's words mean"
    ] = field(default_factory=dict)
    empty_refuses_moves: Annotated[
        bool, "true: at 0 % the robot refuses moves, which the alarm `battery empty` then says"
    ] = False
    period: Period = None
    where: str = _where()


@dataclass(frozen=True)
class MotionTopic:
    """The topic that reports how the robot moves."""

    topic: TopicName
    types: FieldsByType[MotionFields]
    title: Annotated[str, "the title of the panel"] = "Motion"
    time_factor: Annotated[
        ParameterRef | None,
        "for a simulation: how many simulated seconds pass in a real one; "
        "`x 7.5` stands beside the speed and the time left",
    ] = None
    period: Period = None
    where: str = _where()

    @property
    def reports_stop(self) -> bool:
        """True if a message type of the topic tells whether the robot is stopped."""
        return any(fields.stopped for fields in self.types.values())


@dataclass(frozen=True)
class PoseFields:
    """The fields of one message type about where the robot is."""

    x: Annotated[MessageField, "m"]
    y: Annotated[MessageField, "m"]
    orientation: Annotated[MessageField | None, "the quaternion; its yaw is shown, in degrees"] = (
        None
    )
    frame: Annotated[MessageField | None, "the name of the frame that the pose is in"] = None


@dataclass(frozen=True)
class PoseTopic:
    """The topic that reports where the robot is."""

    topic: TopicName
    types: FieldsByType[PoseFields]
    period: Period = None
    where: str = _where()


@dataclass(frozen=True)
class FormField:
    """A field of a goal's form."""

    label: Annotated[str, "what it is called on the screen and in a shell; else its path"] = ""
    low: Annotated[
        Limit, "the least value that is taken; or a parameter: `{node, parameter, otherwise}`"
    ] = None
    high: Annotated[
        Limit, "the greatest value that is taken; or a parameter: `{node, parameter, otherwise}`"
    ] = None
    unit: Annotated[str, "what is shown behind it"] = ""
    convert: Annotated[
        Literal["yaw"] | None, "`yaw`: degrees are typed, and a quaternion is sent"
    ] = None
    where: str = _where()

    def faults(self) -> Faults:
        yield from _order("low", self.low, "high", self.high)


@dataclass(frozen=True)
class RemainingField:
    """The feedback field that holds the distance or work still to be done."""

    field: Annotated[str, "its dotted path in the feedback"]
    unit: Annotated[str, "what is shown behind it"] = ""
    length: Annotated[
        Limit,
        "the length of the whole way; or a parameter: `{node, parameter, otherwise}`; "
        "without it, and while no node has it, the first remainder",
        _LENGTH,
    ] = None
    where: str = _where()


@dataclass(frozen=True)
class GoalKind:
    """An action of the robot, with the form to fill in."""

    id: Annotated[str, "what is typed in a shell; the first goal is `go`"]
    title: Annotated[str, "what it is called on the screen", _title]
    action: Annotated[str, "the action's name", _name]
    type: Annotated[str, "its type: `package/action/Name`", _ACTION]
    noun: Annotated[
        str, "what a goal leads to: `12 m before shelf 12`; empty: it leads nowhere"
    ] = ""
    key: Annotated[str, "its key; the first goal has `g`"] = ""
    form: Annotated[Mapping[str, FormField], "what is typed, by dotted path in the goal"] = field(
        default_factory=dict
    )
    fixed: Annotated[Mapping[str, Any], "what is always sent, by dotted path in the goal"] = field(
        default_factory=dict
    )
    remaining: Annotated[RemainingField | None, "how much is left"] = None
    message: Annotated[str, "the result's field with the robot's own words for the end"] = ""
    refusals: Annotated[
        str, "log lines of the action's node that begin so hold the reason of a refusal"
    ] = ""
    stop_cancels: Annotated[
        bool, "false: a STOP does not cancel its goals, since a cancel sets the robot in motion"
    ] = True
    where: str = _where()

    def faults(self) -> Faults:
        labels = [(given.label or path, given) for path, given in self.form.items()]
        # `--plain` takes `label=value` in any case.
        yield from _duplicates((given.where, "label", label.lower()) for label, given in labels)
        for path, given in self.form.items():
            for other in (*self.form, *self.fixed):
                if other != path and other.startswith(f"{path}."):
                    yield given.where, f"{other} is a part of {path}: give one of them"
            if path in self.fixed:
                yield given.where, f"{path} is both in the form and fixed: give one of them"


@dataclass(frozen=True)
class StopServices:
    """The services of the software stop."""

    service: Annotated[str, "the service that stops", _name]
    request: Annotated[
        Mapping[str, Scalar], "what is sent to stop, by field; left out: the request has no field"
    ] = field(default_factory=dict)
    release: Annotated[
        str,
        "the service that releases the stop; it may be the same one with another request",
        _name,
    ] = ""
    release_request: Annotated[
        Mapping[str, Scalar], "what is sent to release, by field; left out: it has no field"
    ] = field(default_factory=dict)
    where: str = _where()

    def faults(self) -> Faults:
        is_same = self.release.lstrip("/") == self.service.lstrip("/")
        if is_same and self.release_request == self.request:
            same = f"release is the service that stops, {self.service}"
            yield "", f"{same}: give it a release_request of its own, name another or none"
        if self.release_request and not self.release:
            yield "", "release_request is for a release: name its service"


_READINGS = ("battery.charging", "motion.moving", "motion.stopped", "ask")


@dataclass(frozen=True)
class CommandService:
    """A command: a service whose request has no field, or one bool that is toggled."""

    id: Annotated[str, "what is typed in a shell"]
    title: Annotated[str, "what it is called on the screen", _title]
    service: Annotated[str, "the service's name", _name]
    key: Annotated[str, "its key"] = ""
    help: Annotated[
        str,
        "one sentence for the help; else the title; for a toggle with `off`, the words after "
        "`, or` are the help of `off`",
    ] = ""
    ask: Annotated[
        Literal["moving", "always", "never"],
        "when a question comes first; `moving`: while a goal runs",
    ] = "never"
    toggle: Annotated[
        Mapping[str, str],
        "the request's bool, and the reading that it inverts: "
        "`battery.charging`, `motion.moving` or `motion.stopped`; or `ask`: the key asks on or off",
        filled,
    ] = field(default_factory=dict)
    off: Annotated[
        str,
        "what a toggle is called, and typed, when it sends false; "
        'written `"off":`, since some editors take the bare word for false',
    ] = ""
    where: str = _where()

    @property
    def off_word(self) -> str:
        """The word that is typed for a toggle to send false; "" if this is not a toggle."""
        return (self.off or f"{self.id}_off") if self.toggle else ""

    def faults(self) -> Faults:
        if self.off and not self.toggle:
            yield "", f"off is for a toggle: {self.id} has none"
        if len(self.toggle) > 1:
            yield "", "toggle takes one field of the request"
        for reading in self.toggle.values():
            if reading not in _READINGS:
                yield "", f"toggle inverts one of {', '.join(_READINGS)}, not {reading}"

    def toggles_reading_of(self, topic: Literal["battery", "motion"]) -> bool:
        """Return True if this toggle inverts a state that the topic reports: `battery.charging`."""
        return any(reading.startswith(f"{topic}.") for reading in self.toggle.values())


@dataclass(frozen=True)
class Gauge:
    """A further number that the robot reports."""

    title: Annotated[str, "what it is called on the screen", _title]
    topic: TopicName
    type: Annotated[str, "its type: `package/msg/Name`", _MESSAGE]
    field: Annotated[MessageField, "where the number stands"]
    unit: Annotated[str, "what is shown behind it"] = ""
    low: Annotated[float | None, "what is below is no reading"] = None
    high: Annotated[float | None, "what is above is no reading"] = None
    warn_below: Annotated[float | None, "what is below is an alarm"] = None
    warn_above: Annotated[float | None, "what is above is an alarm"] = None
    where: str = _where()

    def faults(self) -> Faults:
        yield from _order("low", self.low, "high", self.high)
        yield from _order("warn_below", self.warn_below, "warn_above", self.warn_above)


@dataclass(frozen=True)
class Place:
    """The values of a goal under a name."""

    name: Annotated[str, "what is typed: `go dock`", _place]
    values: Annotated[Mapping[str, Scalar], "the values, by dotted path as in the goal's `form`"]
    goal: Annotated[str, "the goal's id; the first one if it is left out"] = ""
    where: str = _where()


@dataclass(frozen=True)
class TopicRule:
    """A topic, as far as the file knows it."""

    topic: TopicName
    # The graph cannot tell whether a message sets the robot in motion, so the file says it.
    moves: Annotated[bool, "false: what is published there never sets the robot in motion"] = True
    rate: Annotated[
        float | None,
        "the messages a second that are expected, in Hz; the console subscribes to it",
        _RATE,
    ] = None
    tolerance: Annotated[
        float, "the share by which the rate may differ; more is an alarm", _SHARE
    ] = 0.2
    where: str = _where()


@dataclass(frozen=True)
class FrameRule:
    """A frame that must be alive; the console then receives /tf and /tf_static."""

    frame: Annotated[str, "the frame's name, as the transform to it has it"]
    age: Annotated[float, "how old its transform may be, in s; more is an alarm", _PERIOD] = 1.0
    where: str = _where()


@dataclass(frozen=True)
class RobotFile:
    """A robot file."""

    version: Annotated[Literal[1], "version of the file format"] = 1
    name: Annotated[str, "what the robot is called"] = "robot"
    battery: Annotated[BatteryTopic | None, "the topic that tells the charge"] = None
    motion: Annotated[MotionTopic | None, "the topic that tells how the robot moves"] = None
    pose: Annotated[PoseTopic | None, "the topic that tells where the robot is"] = None
    goals: Annotated[
        tuple[GoalKind, ...], "the actions; the first one has its form on the screen"
    ] = ()
    stop: Annotated[
        StopServices | None, "the services of the software stop; `none`: it has no STOP"
    ] = None
    commands: Annotated[
        tuple[CommandService, ...], "services with a key and a word of their own"
    ] = ()
    gauges: Annotated[tuple[Gauge, ...], "further numbers, with alarms"] = ()
    diagnostics: Annotated[
        str, "the topic of diagnostic_msgs/msg/DiagnosticArray: what is not OK is an alarm", _name
    ] = ""
    record: Annotated[
        tuple[str, ...], "further topics for the black box, which are not shown", _names
    ] = ()
    shown: Annotated[
        tuple[str, ...],
        "the parameters that an operator changes; the others of their nodes are shown by a key",
    ] = ()
    places: Annotated[tuple[Place, ...], "goals under a name"] = ()
    topics: Annotated[tuple[TopicRule, ...], "what is known of topics, whoever reads them"] = ()
    frames: Annotated[tuple[FrameRule, ...], "the frames that must be alive"] = ()

    def faults(self) -> Faults:
        yield from self._word_faults()
        # The title identifies a gauge's alarm.
        yield from _duplicates((gauge.where, "title", gauge.title) for gauge in self.gauges)
        yield from _duplicates((place.where, "place", place.name) for place in self.places)
        goals = {goal.id: goal for goal in self.goals}
        for place in self.places:
            goal = goals.get(place.goal) if place.goal else next(iter(self.goals), None)
            if goal is None:
                yield place.where, f"{place.goal or 'its goal'} is no goal of this file"
            elif place.values.keys() != goal.form.keys():
                wanted = ", ".join(goal.form) or "none"
                yield (
                    place.where,
                    f"{place.name} needs a value for each field of the form: {wanted}",
                )

    def _word_faults(self) -> Faults:
        found = [(goal.where, "id", goal.id) for goal in self.goals]
        found += [(command.where, "id", command.id) for command in self.commands]
        found += [(c.where, "word", c.off_word) for c in self.commands if c.off_word]
        for where, what, word in found:
            if not _ID.fullmatch(word):
                yield where, f"{word!r} is not a valid {what}: small letters, digits and _"
            if word in RESERVED:
                yield where, f"the {what} {word} is the console's own: choose another"
        yield from _duplicates(found)

    @property
    def shown_topics(self) -> tuple[str, ...]:
        """The names of all topics whose messages are shown, each once; not those of `record`."""
        topics = (self.battery, self.motion, self.pose)
        named = [topic.topic for topic in topics if topic] + [gauge.topic for gauge in self.gauges]
        return tuple(dict.fromkeys([*named, *filter(None, [self.diagnostics])]))

    @property
    def further_topics(self) -> tuple[str, ...]:
        """The names of all topics of `record`, and of those with a rate that are not shown."""
        rated = [rule.topic for rule in self.topics if rule.rate is not None]
        named = dict.fromkeys([*self.record, *rated])
        return tuple(name for name in named if name not in self.shown_topics or name in self.record)

    @property
    def services(self) -> tuple[str, ...]:
        """The names of all services that the console calls, each once, the STOP's first."""
        stop = () if self.stop is None else (self.stop.service, self.stop.release)
        named = [*stop, *(command.service for command in self.commands)]
        return tuple(name for name in dict.fromkeys(named) if name)


_UNITS = {"percentage": "%", "voltage": "V", "x": "m", "y": "m"}  # Of readings, by their names.


def field_units(
    file: RobotFile, full_name: Callable[[str], str], topic: str, type_name: str
) -> dict[str, str]:
    """Return the units of a topic's fields by path, as far as the robot file tells them.

    A field with a scale, an offset or a condition is left out: its unit in the message is unknown.
    """
    found: list[tuple[Any, str]] = []
    for described in (file.battery, file.motion, file.pose):
        if described is not None and full_name(described.topic) == topic:
            readings = vars(described.types[type_name]) if type_name in described.types else {}
            found += [(given, _UNITS.get(name, "")) for name, given in readings.items()]
    for gauge in file.gauges:
        if full_name(gauge.topic) == topic and gauge.type == type_name:
            found.append((gauge.field, gauge.unit))
    return {
        given.field: given.unit or unit
        for given, unit in found
        if isinstance(given, MessageField) and (given.unit or unit)
        # Nothing but the path and the unit is given.
        if given == MessageField(given.field, unit=given.unit)
    }
