"""The dataclasses of a robot file: the topics, actions and services that the console uses.

Everything is optional: a robot that lacks something leaves it out, and the screen shows it greyed.
`where` holds `FILE:LINE`, for messages about that entry. The text beside each type is its
documentation: `python -m tests.generated` makes docs/own_robot.md and config/robots/schema.json of
it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

NO_STOP = "has no STOP: use the hardware stop"  # Said of a robot whose file names no stop service.

Scalar = bool | int | float | str


def _where() -> Any:
    return field(default="", compare=False, repr=False)


@dataclass(frozen=True)
class MessageField:
    """The field of a message that holds a reading, and how to convert its value."""

    field: Annotated[str, "its dotted path in the message"]
    scale: Annotated[float, "factor that makes it a value of the unit"] = 1.0
    offset: Annotated[float, "added after scaling"] = 0.0
    equals: Annotated[Scalar | None, "true when the value is this"] = None
    beyond: Annotated[float | None, "true when the value's size is larger"] = None
    unit: Annotated[str, "what is shown behind it"] = ""
    where: str = _where()


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
    ] = None
    stopped: Annotated[MessageField | None, "true while the software stop is latched"] = None


@dataclass(frozen=True)
class BatteryTopic:
    """The topic that reports the charge."""

    topic: Annotated[str, "the topic's name"]
    types: Annotated[
        Mapping[str, BatteryFields],
        "the fields, by message type; a topic of another type is not used",
    ]
    low: Annotated[
        Limit, "%; a charge below it is low; or a parameter: `{node, parameter, otherwise}`"
    ] = None
    health: Annotated[
        Mapping[str, Literal["good", "low", "replace"]], "what the battery's words mean"
    ] = field(default_factory=dict)
    empty_refuses_moves: Annotated[
        bool, "true: at 0 % the robot refuses moves, which the alarm `battery empty` then says"
    ] = False
    period: Annotated[float | None, "s between two messages; measured when left out"] = None
    where: str = _where()


@dataclass(frozen=True)
class MotionTopic:
    """The topic that reports how the robot moves."""

    topic: Annotated[str, "the topic's name"]
    types: Annotated[
        Mapping[str, MotionFields],
        "the fields, by message type; a topic of another type is not used",
    ]
    title: Annotated[str, "the title of the panel"] = "Motion"
    time_factor: Annotated[
        ParameterRef | None,
        "for a simulation: how many simulated seconds pass in a real one; "
        "`x 7.5` stands beside the speed and the time left",
    ] = None
    period: Annotated[float | None, "s between two messages; measured when left out"] = None
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

    topic: Annotated[str, "the topic's name"]
    types: Annotated[
        Mapping[str, PoseFields],
        "the fields, by message type; a topic of another type is not used",
    ]
    period: Annotated[float | None, "s between two messages; measured when left out"] = None
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


@dataclass(frozen=True)
class RemainingField:
    """The feedback field that holds the distance or work still to be done."""

    field: Annotated[str, "its dotted path in the feedback"]
    unit: Annotated[str, "what is shown behind it"] = ""
    length: Annotated[
        Limit,
        "the length of the whole way; or a parameter: `{node, parameter, otherwise}`; "
        "without it, and while no node has it, the first remainder",
    ] = None
    where: str = _where()


@dataclass(frozen=True)
class GoalKind:
    """An action of the robot, with the form to fill in."""

    id: Annotated[str, "what is typed in a shell; the first goal is `go`"]
    title: Annotated[str, "what it is called on the screen"]
    action: Annotated[str, "the action's name"]
    type: Annotated[str, "its type: `package/action/Name`"]
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


@dataclass(frozen=True)
class StopServices:
    """The services of the software stop."""

    service: Annotated[str, "the service that stops"]
    request: Annotated[
        Mapping[str, Scalar], "what is sent to stop, by field; left out: the request has no field"
    ] = field(default_factory=dict)
    release: Annotated[
        str, "the service that releases the stop; it may be the same one with another request"
    ] = ""
    release_request: Annotated[
        Mapping[str, Scalar], "what is sent to release, by field; left out: it has no field"
    ] = field(default_factory=dict)
    where: str = _where()


@dataclass(frozen=True)
class CommandService:
    """A command: a service whose request has no field, or one bool that is toggled."""

    id: Annotated[str, "what is typed in a shell"]
    title: Annotated[str, "what it is called on the screen"]
    service: Annotated[str, "the service's name"]
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
    ] = field(default_factory=dict, metadata={"filled": True})  # `toggle: {}` is refused.
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

    def toggles_reading_of(self, topic: Literal["battery", "motion"]) -> bool:
        """Return True if this toggle inverts a state that the topic reports: `battery.charging`."""
        return any(reading.startswith(f"{topic}.") for reading in self.toggle.values())


@dataclass(frozen=True)
class Gauge:
    """A further number that the robot reports."""

    title: Annotated[str, "what it is called on the screen"]
    topic: Annotated[str, "the topic's name"]
    type: Annotated[str, "its type: `package/msg/Name`"]
    field: Annotated[MessageField, "where the number stands"]
    unit: Annotated[str, "what is shown behind it"] = ""
    low: Annotated[float | None, "what is below is no reading"] = None
    high: Annotated[float | None, "what is above is no reading"] = None
    warn_below: Annotated[float | None, "what is below is an alarm"] = None
    warn_above: Annotated[float | None, "what is above is an alarm"] = None
    where: str = _where()


@dataclass(frozen=True)
class Place:
    """The values of a goal under a name."""

    name: Annotated[str, "what is typed: `go dock`"]
    values: Annotated[Mapping[str, Scalar], "the values, by dotted path as in the goal's `form`"]
    goal: Annotated[str, "the goal's id; the first one if it is left out"] = ""
    where: str = _where()


@dataclass(frozen=True)
class TopicRule:
    """A topic, as far as the file knows it."""

    topic: Annotated[str, "the topic's name"]
    # The graph cannot tell whether a message sets the robot in motion, so the file says it.
    moves: Annotated[bool, "false: what is published there never sets the robot in motion"] = True
    rate: Annotated[
        float | None, "the messages a second that are expected, in Hz; the console subscribes to it"
    ] = None
    tolerance: Annotated[float, "the share by which the rate may differ; more is an alarm"] = 0.2
    where: str = _where()


@dataclass(frozen=True)
class FrameRule:
    """A frame that must be alive; the console then receives /tf and /tf_static."""

    frame: Annotated[str, "the frame's name, as the transform to it has it"]
    age: Annotated[float, "how old its transform may be, in s; more is an alarm"] = 1.0
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
        str, "the topic of diagnostic_msgs/msg/DiagnosticArray: what is not OK is an alarm"
    ] = ""
    record: Annotated[tuple[str, ...], "further topics for the black box, which are not shown"] = ()
    shown: Annotated[
        tuple[str, ...],
        "the parameters that an operator changes; the others of their nodes are shown by a key",
    ] = ()
    places: Annotated[tuple[Place, ...], "goals under a name"] = ()
    topics: Annotated[tuple[TopicRule, ...], "what is known of topics, whoever reads them"] = ()
    frames: Annotated[tuple[FrameRule, ...], "the frames that must be alive"] = ()

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


def field_units(
    file: RobotFile, full_name: Callable[[str], str], topic: str, type_name: str
) -> dict[str, str]:
    """Return the units of a topic's fields by path, as far as the robot file tells them.

    A field with a scale, an offset or a condition is left out: its unit in the message is unknown.
    """
    found: list[tuple[MessageField | None, str]] = []
    if file.battery is not None and full_name(file.battery.topic) == topic:
        battery = file.battery.types.get(type_name)
        if battery is not None:
            found += [(battery.percentage, "%"), (battery.voltage, "V")]
    if file.pose is not None and full_name(file.pose.topic) == topic:
        pose = file.pose.types.get(type_name)
        if pose is not None:
            found += [(pose.x, "m"), (pose.y, "m")]
    if file.motion is not None and full_name(file.motion.topic) == topic:
        motion = file.motion.types.get(type_name)
        if motion is not None:
            found += [(motion.count, ""), (motion.speed, "")]
    found += [
        (gauge.field, gauge.unit)
        for gauge in file.gauges
        if full_name(gauge.topic) == topic and gauge.type == type_name
    ]
    return {
        field.field: field.unit or unit
        for field, unit in found
        if field is not None and _is_unconverted(field) and (field.unit or unit)
    }


def _is_unconverted(field: MessageField) -> bool:
    is_number = field.equals is None and field.beyond is None
    return field.scale == 1.0 and field.offset == 0.0 and is_number
