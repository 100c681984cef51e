"""The state of the robot as it is shown: a snapshot, and the types of what is in it.

They are frozen. `received`, `sent` and the like are seconds on the monotonic clock of this
process, `time` is a Unix time. None means that nothing was received, or that this robot does not
report it. Recordings have the names of the attributes. The `period` of a reading is that of the
robot file or the measured one; without one, `grace` is the silence in seconds that is allowed, None
for any.

Most are NamedTuples, which are made and copied in a fraction of a dataclass's time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum, auto
from types import MappingProxyType
from typing import Any, NamedTuple

from archo_tui.clock import Monotonic, UnixTime
from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.messages.values import number, same, text_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.period import UNMEASURED, MessageRate, is_silent
from archo_tui.robot_file.model import FormField, Gauge, GoalKind, Limit, ParameterRef, RobotFile


class Battery(NamedTuple):
    """The last battery reading."""

    percentage: float | None = None  # The charge in %; None if it was not within 0 .. 100.
    voltage: float | None = None  # The voltage in V.
    charging: bool | None = None
    health: str | None = None  # The battery's own word for its health.
    received: float | None = None
    period: float | None = 1.0  # Without meaning before the first message.
    unreadable: str = ""  # What was received instead of a percentage; "" if one was.
    grace: float | None = UNMEASURED
    discharging: bool | None = None

    def is_old(self, now: float) -> bool:
        """Return True after three periods of silence, at least 2.5 s; False before any message."""
        return is_silent(self.received, self.period, now, self.grace)


@dataclass(frozen=True)  # A tuple has a `count` of its own.
class Motion:
    """The motion that the robot has reported last."""

    count: int | None = None  # The ticks of the encoder, or whatever the robot file names.
    speed: float | None = None  # The speed, in the unit of the robot file.
    moving: bool | None = None
    stopped: bool | None = None  # True while its software stop is latched.
    received: float | None = None
    period: float | None = 0.2
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True after three periods of silence, at least 2.5 s; False before any message."""
        return is_silent(self.received, self.period, now, self.grace)


class Pose(NamedTuple):
    """The pose that the robot has reported last."""

    x: float | None = None  # In m.
    y: float | None = None  # In m.
    # The direction in degrees, counter-clockwise from the x axis, -180 to 180.
    yaw: float | None = None
    frame: str = ""  # The name of the frame that the pose is in; "" if it is not reported.
    received: float | None = None
    period: float | None = None
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True after three periods of silence, at least 2.5 s; False before any message."""
        return is_silent(self.received, self.period, now, self.grace)


class GaugeReading(NamedTuple):
    """The last number of one of the robot's gauges."""

    gauge: Gauge
    value: float | None = None
    received: float | None = None
    period: float | None = None
    unreadable: str = ""  # What was received instead of a number; "" if one was.
    grace: float | None = UNMEASURED

    def is_old(self, now: float) -> bool:
        """Return True after three periods of silence, at least 2.5 s; False before any message."""
        return is_silent(self.received, self.period, now, self.grace)

    @property
    def warning(self) -> str:
        """A text such as `above 60` if the number is beyond a limit of the robot file; else ""."""
        value, below, above = self.value, self.gauge.warn_below, self.gauge.warn_above
        if value is not None and below is not None and value < below:
            return f"below {below:g}"
        if value is not None and above is not None and value > above:
            return f"above {above:g}"
        return ""


# Seconds after which a status is stale, at least. diagnostic_updater publishes each second, and
# diagnostic_aggregator calls a status stale after 5 s.
LEAST_STALE = 5.0
GONE = 60.0  # Seconds of silence after which a part may be forgotten; our choice.


class DiagnosticLevel(Enum):
    """The levels of diagnostic_msgs/msg/DiagnosticStatus, by their words."""

    OK = "OK"
    WARN = "WARN"
    ERROR = "ERROR"
    STALE = "STALE"


# The levels, the worst first: of a silent part is known less than of one that warns.
WORST_FIRST = (
    *(DiagnosticLevel.ERROR, DiagnosticLevel.WARN, DiagnosticLevel.STALE),
    DiagnosticLevel.OK,
)


class Diagnostic(NamedTuple):
    """The last status of one part of the robot."""

    name: str  # The name of the part, as diagnostics have it: `base: left motor`.
    hardware_id: str  # The part's serial number or the like; may be "".
    level: DiagnosticLevel
    message: str
    received: float  # When the last status came, in monotonic seconds.
    period: float | None = None  # The typical interval of its statuses in seconds.

    @property
    def key(self) -> tuple[str, str]:
        """The name and the hardware id, by which parts differ."""
        return self.name, self.hardware_id

    @property
    def part(self) -> str:
        """The part as people read it: `base: left motor (sn 12)`."""
        return f"{self.name} ({self.hardware_id})" if self.hardware_id else self.name

    def is_gone_at(self, now: float) -> bool:
        """Return True if it is stale, and has been silent for at least GONE seconds."""
        return self.is_silent_at(now) and now - self.received >= GONE

    def level_at(self, now: float) -> DiagnosticLevel:
        """Return the reported level, or STALE after three periods of silence, at least 5 s."""
        return DiagnosticLevel.STALE if self.is_silent_at(now) else self.level

    def is_silent_at(self, now: float) -> bool:
        """Return True after three periods without a status, at least 5 s."""
        return now - self.received > max(3 * (self.period or 0.0), LEAST_STALE)


MASK = "***"  # In place of a secret value.


def in_namespace(namespace: str, name: str) -> str:
    """Return a name of the robot file as a full name in a namespace.

    A name that begins with `/` is full already, and is returned as it is.
    """
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def logger_node(logger: str) -> str:
    """Return the full name of the node whose logger has a name such as `north.lamp`."""
    return "/" + logger.replace(".", "/")


def not_offered(name: str) -> str:
    """Return the text that no node offers a service or an action."""
    return f"{name} is not offered by any node"


LEVELS = {"UNSET": 0, "DEBUG": 10, "INFO": 20, "WARN": 30, "ERROR": 40, "FATAL": 50}
_WORDS = {number: word for word, number in LEVELS.items() if number}

Names = tuple[tuple[str, str], ...]  # Each with its type.


class NodeState(NamedTuple):
    """A node on the graph."""

    name: str
    heard: Monotonic | None = None  # When its last message or log line came, in monotonic seconds.
    rate: float | None = None  # The rate in Hz of its messages that the console reads.
    # The state of a managed node, as `inactive`, or `inactive, no answer` if it did not answer the
    # last question; "" if it is not managed, or was not asked yet.
    lifecycle: str = ""

    def is_silent(self, now: float) -> bool:
        """Return True if nothing was received for three intervals of its rate, at least 2.5 s.

        Before the first message, or without a rate, it is False.
        """
        return is_silent(self.heard, 1 / self.rate if self.rate else None, now, None)


def level_word(number: Any) -> str:
    """Return the word for a log message's level: 10 is `DEBUG`; INFO for anything unknown."""
    return _WORDS.get(number, "INFO") if isinstance(number, int) else "INFO"


class LogLevel(NamedTuple):
    """The level of a node's log, as words of LEVELS."""

    own: str  # The level that was set for it; UNSET if none was.
    in_force: str  # The level that holds: its own, or that of its process.

    @property
    def text(self) -> str:
        """The level as text: `DEBUG and above`, or `INFO and above, the level of its process`."""
        process = ", the level of its process" if self.own == "UNSET" else ""
        return f"{self.in_force} and above{process}"


class NodeInfo(NamedTuple):
    """The topics, services and actions of one node, without those that every node has."""

    publishes: Names = ()
    subscribes: Names = ()  # The topics to which it subscribes.
    serves: Names = ()
    calls: Names = ()  # The services for which it has a client.
    actions: Names = ()
    sends: Names = ()  # The actions for which it has a client.
    transitions: tuple[str, ...] = ()  # The transitions that a managed node can make now.
    level: LogLevel | None = None  # The level of its log; None if the node does not report it.
    no_level: str = ""  # Why `level` is None; "" if it is not.


TOPIC, SERVICE, ACTION = "topic", "service", "action"


class Resource(NamedTuple):
    """A topic, a service or an action, and the nodes that publish or serve it."""

    kind: str  # TOPIC, SERVICE or ACTION.
    name: str
    types: tuple[str, ...]  # Its types: several if nodes disagree.
    nodes: tuple[str, ...]  # The full names of the nodes that publish or serve it.
    # For a topic, a text with the remedy for each node that receives nothing, or may misread what
    # it receives.
    mismatches: tuple[str, ...] = ()


# Why the parameters of a node are not known.
NOT_REPORTED, NO_PARAMETER_SERVICES = (
    "has not reported its parameters",
    "has no parameter services",
)
_FARTHEST = 1e15  # A double has so many digits.


class Parameter(NamedTuple):
    """A parameter of a node, as the node has reported it."""

    node: str
    name: str
    # `bool`, `integer`, `double` or `string`, one of these followed by `[]`, `byte[]`, or `not
    # set`.
    type: str
    value: Any  # Its value; None if it is not set.
    initial: Any  # The value when it was first seen.
    description: str = ""
    low: float | None = None  # The smallest value allowed; None for any.
    high: float | None = None
    read_only: bool = False  # True if it can only be set when its node starts.
    is_secret: bool = False  # True if its name is that of a secret: only the person sees the value.

    @property
    def masked(self) -> Parameter:
        """The same parameter with MASK in place of its values, if it is secret and has one."""
        if not self.is_secret or self.value is None:
            return self
        return self._replace(value=MASK, initial=MASK)

    @property
    def is_changed(self) -> bool:
        """True if the value differs from the one that was first seen."""
        return not same(self.value, self.initial)


def linked_number(
    parameters: Iterable[Parameter],
    namespace: str,
    link: ParameterRef,
    low: float = -_FARTHEST,
    high: float = _FARTHEST,
) -> float | None:
    """Return the number of the parameter to which a robot file refers."""
    wanted = (in_namespace(namespace, link.node), link.parameter)
    for parameter in parameters:
        if (parameter.node, parameter.name) == wanted:
            found = number(parameter.value, low, high)
            return link.otherwise if found is None else found
    return link.otherwise


class TopicEnd(NamedTuple):
    """A publisher or a subscription."""

    node: str
    type: str  # The type of its messages.
    qos: str  # Its reliability and durability in DDS's words: `RELIABLE, VOLATILE`.


class TopicInfo(NamedTuple):
    """The publishers and subscriptions of a topic."""

    publishers: tuple[TopicEnd, ...] = ()  # The publishers, sorted by node.
    subscriptions: tuple[TopicEnd, ...] = ()  # The subscriptions, sorted by node.
    # A text with the remedy for each subscribing node that receives nothing, or may misread what it
    # receives.
    mismatches: tuple[str, ...] = ()


Range = tuple[float, float]  # The least and the greatest value.
Curve = tuple[Range | None, ...]  # The values of the last minute, the oldest first; None: no value.


SHOWN_ELEMENTS = 20  # Of an open array.


class FieldKind(Enum):
    """The kinds of rows of a message."""

    VALUE = auto()  # A number, a text, a bool or a time.
    GROUP = auto()  # A message, whose fields follow.
    ARRAY = auto()
    MORE = auto()  # The elements of an open array that are not shown.


class FieldView(NamedTuple):
    """A row for a field of a message, or for an element of an array that is open."""

    path: str  # Its dotted path: `pose.position.x`, `ranges[3]`.
    kind: FieldKind
    type: str  # Its type as .msg files write it; of an array with its length: `float32[360]`.
    value: bool | float | str | None = None  # Its value, NaN also; None for a group.
    is_time: bool = False  # True if the value is a time of day.
    unit: str = ""  # Its unit; "" if neither its definition nor the robot file names one.
    constant: str = ""  # The name that the type gives to this value, or "".
    least: float | None = None  # The least value since the topic was opened.
    greatest: float | None = None  # The greatest value, as `least`.
    nan: int = 0  # Of an array, the number of elements that are NaN.
    first: str = ""  # Of an array of bytes, the first ones in hexadecimal.
    is_open: bool = False  # True for an array whose elements follow.
    curve: Curve = ()  # Its values of the last minute; () if they were not asked for.


class TopicView(NamedTuple):
    """A topic at one moment."""

    topic: str
    type: str = ""  # The type of its messages; "" while none is known.
    received: int = 0  # The number of messages that came since the topic was opened.
    rate: float | None = None  # The messages in a second; None before three intervals.
    bytes_per_second: float | None = None  # The bytes of these messages in a second.
    age: float | None = None  # Seconds since the last message.
    fields: tuple[FieldView, ...] = ()  # The rows for the fields of the last message, in its order.
    is_cut: bool = False  # True if the message has more fields than are shown.
    # The values of the last minute by path, for those that were asked for.
    plots: Mapping[str, Curve] = {}
    ends: TopicInfo | None = None  # Its publishers and subscriptions; None if they are not known.
    fault: str = ""  # Why nothing is shown, or why not the last message; "" if nothing is wrong.
    # The arrays whose elements are among the fields: by path, the first element.
    open_arrays: Mapping[str, int] = {}
    # Takes this view and other `open_arrays`, and returns the view with the elements of these, from
    # the same message.
    with_elements: Callable[[TopicView, Mapping[str, int]], TopicView] | None = None


class TopicRequest(NamedTuple):
    """The parts of a view that a screen needs."""

    # The arrays whose elements are shown: by path, the index of the first one shown.
    open_arrays: Mapping[str, int] = {}
    # The paths of the fields whose curve is shown beside them.
    visible: frozenset[str] = frozenset()
    curve_columns: int = 0  # The number of columns of such a curve.
    plotted: tuple[str, ...] = ()  # The paths of the fields that are plotted.
    plot_columns: int = 0  # The number of columns of a plot.


class Life(Enum):
    """The state of a hosted node, or of a program that the console runs."""

    UP = "up"
    STOPPED = "stopped by you"
    CRASHED = "crashed"
    STUCK = "does not stop"
    STARTING = "starting"  # Its constructor has not returned.
    ENDED = "ended"  # Its program has returned.
    WAITING = "waits: release the STOP, then s"  # A program that was to start behind a STOP.

    @property
    def is_running(self) -> bool:
        """True for UP and STARTING: the node can be stopped and not be started."""
        return self in (Life.UP, Life.STARTING)


class Hosted(NamedTuple):
    """A node that this process hosts."""

    name: str
    life: Life = Life.UP
    error: str = ""  # What a callback raised.
    traceback: str = ""  # The traceback of `error`, or "".
    serves: tuple[str, ...] = ()  # The full names of the services and actions that it serves.
    file: str = ""  # The name of the user's file that it comes from; "" for a node of a package.
    saved: UnixTime = 0.0  # The Unix time at which the text that runs was saved.


GIVEN_UP = 30.0  # Our choice: the seconds that a goal is LOST until its end is not awaited more.


class Phase(Enum):
    """The phase of a goal; the value is the word on the screen."""

    SENT = "SENT"
    REFUSED = "REFUSED"
    MOVING = "MOVING"
    CANCELLING = "CANCELLING"
    CANCELLED = "CANCELLED"
    ARRIVED = "ARRIVED"
    ABORTED = "ABORTED"
    UNKNOWN = "UNKNOWN"  # The server has not answered in time.
    LOST = "LOST"  # No server is found, or the feedback ended.
    DISPUTED = "ENDED"  # The status of the action and its result differ.
    GONE = "GONE"  # Its node has left: no message will tell how it ended.


_CODES = {  # Of the phases of ended goals.
    Phase.ARRIVED: Code.ARRIVED,
    Phase.CANCELLED: Code.CANCELLED,
    Phase.ABORTED: Code.ABORTED,
    Phase.REFUSED: Code.REFUSED,
    Phase.DISPUTED: Code.NOT_CONFIRMED,
    Phase.GONE: Code.TIMEOUT,
}
RUNNING = (Phase.SENT, Phase.MOVING, Phase.CANCELLING, Phase.UNKNOWN, Phase.LOST)


def values_text(kind: GoalKind, values: Mapping[str, Any]) -> str:
    """Return the values of a goal for people: `12` for a single one, else `x 1.5, y 2`.

    A field is named by its label in the robot file, or by its path.
    """
    if len(values) == 1:
        return text_of(*values.values())
    labels = {path: kind.form[path].label or path for path in values if path in kind.form}
    return ", ".join(f"{labels.get(path, path)} {text_of(v)}" for path, v in values.items())


# All of them our choice; times are in seconds.
_WAY_SPAN = 2.0  # The remaining ways of so long tell the present speed,
_WAY_STEP = 0.1  # one in so long,
_LEAST_WAY = 3  # and at least so many.
_LEAST_SHARE = 0.8  # Two speeds that differ by more are not one.
_LATE = 1.0  # An end that is so late was estimated wrongly.


class Goal(NamedTuple):
    """A goal of this console or of another client."""

    kind: GoalKind  # Its kind, in the robot file or made for `send_goal`.
    fields: Mapping[str, Any]  # The values that were typed, by dotted path.
    phase: Phase
    sent: Monotonic
    time: UnixTime  # The Unix time of the last change of its phase.
    length: float | None = None  # The length of the whole way, in the unit of `remaining`.
    # The way that is left by the last feedback, in the unit of the robot file.
    remaining: float | None = None
    heard: Monotonic | None = None  # When the last feedback or answer came.
    started: Monotonic | None = None  # When it was accepted.
    ended: Monotonic | None = None
    cancel_asked: Monotonic | None = None  # When its cancel was requested.
    lost: Monotonic | None = None  # Since when it is LOST.
    unreadable: str = ""  # The last remaining way as received, if it is none; else "".
    feedback: str = ""  # The last feedback as text, field by field.
    message: str = ""  # Why it ended, in the robot's words, or in the console's if there are none.
    mine: bool = True  # False for another client's goal, whose values are not on the graph.
    number: int = 0  # A number that no other goal of this session has.
    # True if `length` is the longest remaining way so far: no node tells it.
    length_is_guessed: bool = False
    result: Any = None  # The result message of the action; None before, and if none came.
    is_found: bool = False  # True if it was underway when it was first seen.
    # The remaining way of the last seconds, by which `seconds_left` goes: pairs of time and way,
    # oldest first.
    way: tuple[tuple[Monotonic, float], ...] = ()
    id: str = ""  # On the ROS graph, in hexadecimal digits; "" before it was sent.

    @property
    def target(self) -> str:
        """The values as typed: `12`, or `x 1.5, y 2`."""
        return values_text(self.kind, self.fields)

    @property
    def name(self) -> str:
        """The goal's name in a sentence: `shelf 12`, `fibonacci 10`, or `another client's goal`."""
        if not self.mine:
            return "another client's goal"
        return f"{self.kind.noun or self.kind.title.lower()} {self.target}".rstrip()

    @property
    def word(self) -> str:
        """The word for its phase on the screen; GONE reads `LOST`.

        A kind of goal without a noun in the robot file is RUNNING and SUCCEEDED instead of MOVING
        and ARRIVED.
        """
        if self.phase == Phase.GONE:
            return str(Phase.LOST.value)
        words = {} if self.kind.noun else {Phase.MOVING: "RUNNING", Phase.ARRIVED: "SUCCEEDED"}
        return words.get(self.phase, str(self.phase.value))

    @property
    def code(self) -> Code | None:
        """The code of its end: TIMEOUT for GONE, NOT_CONFIRMED for DISPUTED; None while it runs."""
        return _CODES.get(self.phase)

    def outcome_at(self, now: float) -> Outcome | None:
        """Return the outcome for a client that waits for the end; None while the goal runs.

        A goal that has been LOST for GIVEN_UP has the outcome TIMEOUT though it is still tracked:
        its end may never be reported.
        """
        if self.lost is not None and now - self.lost >= GIVEN_UP:
            silent = now - (self.heard or self.sent)
            reason = f"no word from it for {silent:.0f} s, the robot may still be moving"
            return Outcome(Code.TIMEOUT, f"goal lost: {reason}")
        if self.code is None:
            return None
        text = self.message or self.word.lower()
        return Outcome(self.code, f"goal lost: {text}" if self.phase == Phase.GONE else text)

    @property
    def is_running(self) -> bool:
        """True while its phase is one of RUNNING, which a goal that is LOST or UNKNOWN still is."""
        return self.phase in RUNNING

    def elapsed(self, now: float) -> float:
        """Return the seconds from its start to its end, or to `now` while it runs.

        The start is when it was accepted, or when it was sent while that is not known.
        """
        start = self.sent if self.started is None else self.started
        return (now if self.ended is None else self.ended) - start

    def seconds_left(self, now: float) -> float | None:
        """Return an estimate of the seconds to its end by its present speed; None without one.

        There is none while the speed changes, and if the estimate proves wrong.
        """
        if len(self.way) < _LEAST_WAY:
            return None
        (begun, before), (heard, left) = self.way[0], self.way[-1]
        recently = [at for at in self.way[:-1] if heard - at[0] >= (heard - begun) / 4]
        whole, present = (
            (away - left) / (heard - at) if heard > at else 0.0
            for at, away in ((begun, before), recently[-1])
        )
        if present <= 0 or not _LEAST_SHARE <= whole / present <= 1 / _LEAST_SHARE:
            return None
        seconds = left / present - (now - heard)
        return max(seconds, 0.0) if seconds > -_LATE else None

    def way_with(self, now: float, remaining: float) -> tuple[tuple[float, float], ...]:
        """Return `way` with one more remaining way, received at `now` in monotonic seconds."""
        way = self.way
        if len(way) > 1 and way[-1][0] - way[-2][0] < _WAY_STEP:
            way = way[:-1]
        recent = tuple(at for at in way if now - at[0] <= _WAY_SPAN)
        return (*(recent if len(recent) > _LEAST_WAY else way[-_LEAST_WAY:]), (now, remaining))

    def fraction(self) -> float:
        """Return the driven share of the way, 0 .. 1; 0 if it is not known."""
        if not self.length or self.remaining is None:
            return 0.0
        return min(max(1 - self.remaining / self.length, 0.0), 1.0)


_NOTHING: Mapping[str, Any] = MappingProxyType({})


class StopAnswer(Enum):
    """The answer so far to a STOP that is not confirmed; the value is the word for it."""

    AWAITED = ""
    NONE = "no answer"  # Not from every server in time.
    NOT_SENT = "NOT SENT"
    REFUSED = "REFUSED"
    UNCONFIRMED = "ANSWERED, NOT CONFIRMED"


class OpenStop(NamedTuple):
    """A STOP that was requested and that the robot has not confirmed."""

    asked: Monotonic  # When it was requested, in monotonic seconds; a repeat does not change it.
    answer: StopAnswer = StopAnswer.AWAITED
    why: str = ""  # Details of the answer for people; "" if there are none.


class Latch(Enum):
    """The state of the last STOP that the robot or another console has reported as confirmed."""

    NONE = "none"  # There was none, or it was released.
    HELD = "held"
    UNCERTAIN = "uncertain"  # It may no longer hold; `Snapshot.latch_doubt` says why.


# The levels of the console's own events: what the person, a shell or an assistant did, how goals
# ended, and what other consoles did.
OWN_LEVELS = ("YOU", "SHELL", "AI", "GOAL", "PEER")
LAUNCH = "launch"  # The source of what the user's launch file says.


@dataclass(frozen=True)  # A tuple has a `count` of its own.
class Event:
    """A log line of a node, or an event of the console. The times are Unix times of the receipt."""

    time: UnixTime  # When it was received; for equal events, when the last of them was.
    level: str  # `DEBUG`, `INFO`, `WARN`, `ERROR`, `FATAL`, or one of OWN_LEVELS.
    source: str  # The name of the logger, or who or what the event is about.
    text: str
    command: str = ""  # The `ros2` command line that does the same; "" if there is none.
    count: int = 1  # The number of equal events for which this one stands.
    first: UnixTime = 0.0  # When the first of these was received.
    number: int = 0  # The number of the first of these, which no other event has.
    audit_record: AuditRecord | None = None  # The record of what was done; None if nothing was.
    code: str = ""  # The code of its outcome, which recordings keep, too; "" if none is known.


class Snapshot(NamedTuple):
    """Everything that a front end can show of the robot, at one moment."""

    file: RobotFile = RobotFile()
    battery: Battery = Battery()
    motion: Motion = Motion()
    pose: Pose = Pose()
    diagnostics: tuple[Diagnostic, ...] = ()  # The last diagnostic status of each part, by name.
    # The last readings of the gauges, in the order of the robot file.
    gauges: tuple[GaugeReading, ...] = ()
    # The goal to show: one of this console, else another's, else the last that ended.
    goal: Goal | None = None
    running: int = 0  # The number of goals that run, of all clients.
    history: tuple[Goal, ...] = ()  # The last 20 goals that ended, newest first.
    parameters: tuple[Parameter, ...] = ()
    # Why a node's parameters are not known, by its full name.
    unreported: Mapping[str, str] = _NOTHING
    nodes: tuple[NodeState, ...] = ()  # The nodes in the robot's namespace.
    # The names of the robot file for which a node publishes or serves something.
    offered: frozenset[str] = frozenset()
    events: tuple[Event, ...] = ()
    # Samples of the charge since charging began or ended: monotonic seconds and percent.
    charge: tuple[tuple[Monotonic, float], ...] = ()
    open_stop: OpenStop | None = None  # The STOP that is not confirmed; None if there is none.
    latch: Latch = Latch.NONE  # The state of the last confirmed STOP.
    latch_doubt: str = ""  # Why `latch` is UNCERTAIN; "" if it is not.
    latch_time: UnixTime = 0.0  # When that STOP was confirmed; 0 before the first.
    # When a release or a goal was last accepted, in monotonic seconds; None if none was.
    released: Monotonic | None = None
    # True if the open STOP was never sent to any node, or, without an open one, if every node that
    # confirmed that STOP ran in this process and has ended, and no further STOP is open.
    stop_held_by_nobody: bool = False
    stop_not_obeyed: bool = False  # True if the robot moves though it has confirmed a STOP.
    # The names of goals that still run after a STOP was answered.
    still_running_after_stop: tuple[str, ...] = ()
    namespace: str = "/"
    # Why a topic, a service or an action is not used, by its name in the robot file.
    faults: Mapping[str, str] = _NOTHING
    # The nodes of each topic of the robot file that several nodes publish.
    publishers: Mapping[str, tuple[str, ...]] = _NOTHING
    duplicate_nodes: tuple[str, ...] = ()  # The names that several nodes have.
    # The nodes of STOP's service and of each action that several nodes serve.
    duplicate_servers: Mapping[str, tuple[str, ...]] = _NOTHING
    has_clock: bool = False  # True if a node publishes simulated time on /clock.
    clock_still_since: Monotonic | None = None  # Since when /clock stands still.
    # The clocks that differ from this computer's: theirs minus ours in seconds, by node or topic.
    clock_offsets: Mapping[str, float] = _NOTHING
    other_namespaces: tuple[str, ...] = ()  # The other namespaces that have nodes.
    consoles: tuple[str, ...] = ()  # The other consoles in this namespace: `user_host_pid`.
    # The fields of each goal's form, by the goal's id, where its type is installed here.
    forms: Mapping[str, tuple[TypedField, ...]] = _NOTHING
    # The types of each action that is served, by its name.
    actions: Mapping[str, tuple[str, ...]] = _NOTHING
    # The types of each service that is served, by its name.
    services: Mapping[str, tuple[str, ...]] = _NOTHING
    # The topics, services and actions, without those that every node has.
    resources: tuple[Resource, ...] = ()
    # The rate of each topic that the console reads, by its full name.
    message_rates: Mapping[str, MessageRate] = _NOTHING

    @property
    def is_stopped(self) -> bool:
        """True while the robot reports that it is stopped, or a STOP holds, is open or in doubt."""
        in_doubt = self.open_stop is not None or self.latch is Latch.UNCERTAIN
        return in_doubt or self.says_stopped or self.stop_holds

    @property
    def simulated_nodes(self) -> tuple[str, ...]:
        """The nodes that go by simulated time."""
        return tuple(
            p.node for p in self.parameters if p.name == "use_sim_time" and p.value is True
        )

    @property
    def has_stop(self) -> bool:
        """True if a STOP can be sent, by the robot file and the nodes that were found so far."""
        stop = self.file.stop
        return stop is not None and not (self.nodes and self.unavailable(stop.service))

    @property
    def stop_holds(self) -> bool:
        """True while the latch is HELD, for a robot that does not report whether it is stopped.

        False for a robot without a service to release a STOP: there a STOP is over as soon as it is
        confirmed.
        """
        stop = self.file.stop
        is_latched = self.latch is Latch.HELD and stop is not None and bool(stop.release)
        return is_latched and self.motion.stopped is None

    @property
    def is_at_rest(self) -> bool:
        """True if the robot reports that it is stopped, or does not move while a STOP holds."""
        return self.says_stopped or (self.stop_holds and not self.motion.moving)

    @property
    def says_stopped(self) -> bool:
        """True if the robot's last report, newer than `released`, is that it is stopped.

        False while the latch is UNCERTAIN.
        """
        heard, released = self.motion.received, self.released
        is_past = heard is not None and released is not None and heard <= released
        return bool(self.motion.stopped) and not is_past and self.latch is not Latch.UNCERTAIN

    @property
    def running_goal(self) -> Goal | None:
        """The goal that is shown, if it runs; else None."""
        return self.goal if self.goal is not None and self.goal.is_running else None

    def full(self, name: str) -> str:
        """Return the full name on the graph of a name in the robot file."""
        return in_namespace(self.namespace, name)

    def unavailable(self, name: str) -> str:
        """Return why a topic, service or action of the robot file cannot be used; "" if it can."""
        return self.faults.get(name, "") if name in self.offered else not_offered(name)

    @property
    def unavailable_names(self) -> frozenset[str]:
        """The names in the robot file that no node offers, or not as the file says."""
        actions = (kind.action for kind in self.file.goals)
        names = (*self.file.topics, *self.file.services, *actions)
        return frozenset(name for name in names if self.unavailable(name))

    def parameter(self, name: str) -> Parameter | None:
        """Return the first parameter of that name, by node names; None if no node has one."""
        return next((p for p in self.parameters if p.name == name), None)

    @property
    def low_charge(self) -> float | None:
        """The charge in % below which the battery is low; None if it is not known."""
        low = None if self.file.battery is None else self.file.battery.low
        if isinstance(low, ParameterRef):
            return linked_number(self.parameters, self.namespace, low, 0.0, 100.0)
        return low

    @property
    def time_factor(self) -> float | None:
        """The simulated seconds in a real one; None if the factor is 1, or is not reported."""
        link = None if self.file.motion is None else self.file.motion.time_factor
        found = None if link is None else linked_number(self.parameters, self.namespace, link, 0.0)
        return None if found == 1.0 else found

    def limit(self, given: Limit) -> float | None:
        """Return the present number of a limit in the robot file; None if there is none."""
        if isinstance(given, ParameterRef):
            return linked_number(self.parameters, self.namespace, given)
        return given

    def form(self, kind: GoalKind) -> Mapping[str, FormField]:
        """Return the fields of a goal's form by path, with the present numbers of their limits."""
        return {
            path: replace(given, low=self.limit(given.low), high=self.limit(given.high))
            for path, given in kind.form.items()
        }
