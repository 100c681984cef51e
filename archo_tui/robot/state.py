"""Frozen snapshots of what was received from the robot: all that a screen can show.

`received`, `sent` and the like are seconds on the monotonic clock of this process; `time` is a
Unix time. None means: never heard, or not reported by this robot.

They are NamedTuples, which are made and copied in a fraction of a dataclass's time; Motion and
Event cannot be, because a tuple has a `count` of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType
from typing import Any, NamedTuple

from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.message_rate import MessageRate
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.period import UNMEASURED, is_silent
from archo_tui.robot.readings import number
from archo_tui.robot.secret_names import MASK
from archo_tui.robot.values import same, text_of
from archo_tui.robot_file.model import FormField, Gauge, GoalKind, Limit, ParameterRef, RobotFile

_FARTHEST = 1e15  # of a number that a parameter holds: so many digits a double has
_NOTHING: Mapping[str, Any] = MappingProxyType({})


class Battery(NamedTuple):
    """The last battery reading."""

    percentage: float | None = None  # %
    voltage: float | None = None  # V
    charging: bool | None = None
    health: str | None = None
    received: float | None = None
    period: float | None = 1.0  # s; None before two readings
    unreadable: str = ""  # what came instead of a percentage
    grace: float | None = UNMEASURED  # s of silence before the period is known; None: any
    discharging: bool | None = None  # None: whenever it does not charge

    def is_old(self, now: float) -> bool:
        """Return True if nothing was received for three of its periods."""
        return is_silent(self.received, self.period, now, self.grace)


@dataclass(frozen=True)
class Motion:
    """The motion that the robot has reported last."""

    count: int | None = None
    speed: float | None = None
    moving: bool | None = None
    stopped: bool | None = None  # latched by the software stop
    received: float | None = None
    period: float | None = 0.2  # s; None before two readings
    grace: float | None = UNMEASURED  # s of silence before the period is known; None: any

    def is_old(self, now: float) -> bool:
        """Return True if nothing was received for three of its periods."""
        return is_silent(self.received, self.period, now, self.grace)


class Reading(NamedTuple):
    """The last number of one of the robot's gauges."""

    gauge: Gauge
    value: float | None = None
    received: float | None = None
    period: float | None = None  # s; None before two readings
    unreadable: str = ""  # what came instead of a number
    grace: float | None = UNMEASURED  # s of silence before the period is known; None: any

    def is_old(self, now: float) -> bool:
        """Return True if nothing was received for three of its periods."""
        return is_silent(self.received, self.period, now, self.grace)

    @property
    def warns(self) -> str:
        """`above 60` when the number is beyond a limit of the robot file, else an empty string."""
        value, below, above = self.value, self.gauge.warn_below, self.gauge.warn_above
        if value is not None and below is not None and value < below:
            return f"below {below:g}"
        if value is not None and above is not None and value > above:
            return f"above {above:g}"
        return ""


class Phase(Enum):
    """The phase of a goal; the value is the word on the screen."""

    SENT = "SENT"
    REFUSED = "REFUSED"
    MOVING = "MOVING"
    CANCELLING = "CANCELLING"
    CANCELLED = "CANCELLED"
    ARRIVED = "ARRIVED"
    ABORTED = "ABORTED"
    UNKNOWN = "UNKNOWN"
    LOST = "LOST"
    DISPUTED = "ENDED"  # the action and its result disagree
    GONE = "GONE"  # its node has gone: nobody will ever tell how it ended


_CODES = {  # of those that ended
    Phase.ARRIVED: Code.ARRIVED,
    Phase.CANCELLED: Code.CANCELLED,
    Phase.ABORTED: Code.ABORTED,
    Phase.REFUSED: Code.REFUSED,
    Phase.DISPUTED: Code.NOT_CONFIRMED,
    Phase.GONE: Code.TIMEOUT,
}
GIVEN_UP = 30.0  # s that a goal is LOST until nobody waits for its end any more
RUNNING = (Phase.SENT, Phase.MOVING, Phase.CANCELLING, Phase.UNKNOWN, Phase.LOST)


def values_text(kind: GoalKind, values: Mapping[str, Any]) -> str:
    """Return the values of a goal for people: `12`, or `x 1.5, y 2`."""
    if len(values) == 1:
        return text_of(*values.values())
    labels = {path: kind.form[path].label or path for path in values if path in kind.form}
    return ", ".join(f"{labels.get(path, path)} {text_of(v)}" for path, v in values.items())


class Goal(NamedTuple):
    """A goal of this console or of another client."""

    kind: GoalKind
    fields: Mapping[str, Any]  # what was typed, by dotted path
    phase: Phase
    sent: float
    time: float  # Unix time of the last change of phase
    length: float | None = None  # of the whole way, in the unit of the kind's remainder
    remaining: float | None = None
    heard: float | None = None  # last feedback or answer
    started: float | None = None  # when it was accepted
    ended: float | None = None
    cancel_asked: float | None = None
    lost: float | None = None  # since when it is LOST
    unreadable: str = ""  # the last remainder as received, when it is not one
    feedback: str = ""  # the last feedback, field by field
    message: str = ""  # the robot's own words for the end, or the reason of a refusal
    mine: bool = True  # else another client's, whose values are not on the graph
    number: int = 0  # tells the goals of a session apart
    length_is_guessed: bool = False  # it is the longest remainder heard: no node tells it
    result: Any = None  # the message that the action has answered at the end
    is_found: bool = False  # it was underway when it was first heard of
    first: tuple[float, float] | None = None  # of one that is_found: monotonic s, and what was left

    @property
    def target(self) -> str:
        """The values as typed: `12`, or `x 1.5, y 2`."""
        return values_text(self.kind, self.fields)

    @property
    def name(self) -> str:
        """The goal's name in a sentence: `shelf 12`, `fibonacci 10`."""
        if not self.mine:
            return "another client's goal"
        return f"{self.kind.noun or self.kind.title.lower()} {self.target}".rstrip()

    @property
    def word(self) -> str:
        """The word for its phase; a goal that leads nowhere runs and succeeds."""
        if self.phase == Phase.GONE:
            return str(Phase.LOST.value)
        words = {} if self.kind.noun else {Phase.MOVING: "RUNNING", Phase.ARRIVED: "SUCCEEDED"}
        return words.get(self.phase, str(self.phase.value))

    @property
    def code(self) -> Code | None:
        """The outcome's code; None while it runs."""
        return _CODES.get(self.phase)

    def outcome_at(self, now: float) -> Outcome | None:
        """Return how it ended, as whoever waits for it is told; None while it runs.

        A goal that is LOST for GIVEN_UP is told as lost, though it is kept: its end may never come.

        Args:
            now: Monotonic time in s.
        """
        if self.lost is not None and now - self.lost >= GIVEN_UP:
            silent = now - (self.heard or self.sent)
            said = f"no word from it for {silent:.0f} s, the robot may still be moving"
            return Outcome(Code.TIMEOUT, f"goal lost: {said}")
        if self.code is None:
            return None
        text = self.message or self.word.lower()
        return Outcome(self.code, f"goal lost: {text}" if self.phase == Phase.GONE else text)

    @property
    def is_running(self) -> bool:
        """True until the robot has said that it ended (or refused), or nobody can any more."""
        return self.phase in RUNNING

    def elapsed(self, now: float) -> float:
        """Seconds driven so far, or in all."""
        start = self.sent if self.started is None else self.started
        return (now if self.ended is None else self.ended) - start

    def seconds_left(self, now: float) -> float | None:
        """Return an estimate from the way that was driven; None before there is any.

        Of a goal that was found underway from what was seen of it: by the robot's clock it may have
        begun at any time, and how long its way is nobody tells.
        """
        since, before = self.first or (None if self.is_found else self.started, self.length)
        if not before or self.remaining is None or self.heard is None or since is None:
            return None
        driven, took = before - self.remaining, self.heard - since
        if driven <= 0 or took <= 0:
            return None
        return max(self.remaining * took / driven - (now - self.heard), 0.0)

    def fraction(self) -> float:
        """0 .. 1 of the route driven."""
        if not self.length or self.remaining is None:
            return 0.0
        return min(max(1 - self.remaining / self.length, 0.0), 1.0)


class TypedField(NamedTuple):
    """A field of a message with a path and a type: a primitive, or an array of anything."""

    path: str  # dotted
    type: str  # as rclpy names it: int32, double, string<10>, sequence<int32>
    default: Any


class Parameter(NamedTuple):
    """A parameter of a node, as the node has reported it."""

    node: str  # fully qualified
    name: str
    type: str  # bool, integer, double, string, or one of them with [] behind it
    value: Any
    initial: Any  # the value first seen
    description: str = ""
    low: float | None = None
    high: float | None = None
    read_only: bool = False
    is_secret: bool = False  # by its name: only the operator sees the value

    @property
    def masked(self) -> Parameter:
        """The same with MASK in place of a secret value."""
        if not self.is_secret or self.value is None:
            return self
        return self._replace(value=MASK, initial=MASK)

    @property
    def is_changed(self) -> bool:
        """True when the value differs from the one first seen."""
        return not same(self.value, self.initial)


class NodeState(NamedTuple):
    """A node on the graph, and when it was last heard."""

    name: str  # fully qualified
    heard: float | None = None
    rate: float | None = None  # Hz of what it publishes for the console

    def is_silent(self, now: float) -> bool:
        """Return True if its topics were not heard for three periods, at least 2.5 s."""
        if self.heard is None or not self.rate:
            return False
        return now - self.heard > max(3 / self.rate, 2.5)


LEVELS = {"UNSET": 0, "DEBUG": 10, "INFO": 20, "WARN": 30, "ERROR": 40, "FATAL": 50}
_WORDS = {number: word for word, number in LEVELS.items() if number}


def level_word(number: Any) -> str:
    """Return the word for a log message's level; INFO for an unknown number."""
    return _WORDS.get(number, "INFO") if isinstance(number, int) else "INFO"


Names = tuple[tuple[str, str], ...]  # each with its type


class LogLevel(NamedTuple):
    """The level of a node's log, as words of LEVELS."""

    own: str  # UNSET: it has none of its own
    in_force: str

    @property
    def text(self) -> str:
        """`DEBUG and above`, or `INFO and above, as its process`."""
        process = ", as its process" if self.own == "UNSET" else ""
        return f"{self.in_force} and above{process}"


class NodeInfo(NamedTuple):
    """The topics, services and actions of one node, without those that every node has."""

    publishes: Names = ()
    subscribes: Names = ()
    serves: Names = ()
    calls: Names = ()
    actions: Names = ()
    sends: Names = ()  # goals
    level: LogLevel | None = None  # None: it does not say
    no_level: str = ""  # why not


TOPIC, SERVICE, ACTION = "topic", "service", "action"


class Resource(NamedTuple):
    """A topic, a service or an action, and the nodes that publish or serve it."""

    kind: str  # TOPIC, SERVICE or ACTION
    name: str  # fully qualified
    types: tuple[str, ...]
    nodes: tuple[str, ...]  # that publish or serve it, fully qualified
    mismatches: tuple[str, ...] = ()  # of a topic: who hears nothing, and what to change


# of the console's own events: what its operator did, how goals ended, what other consoles did
OWN_LEVELS = ("YOU", "SHELL", "AI", "GOAL", "PEER")


WATCHING = "watching only: start archo-tui without --watch to operate the robot"


class Life(Enum):
    """The state of a hosted node."""

    UP = "up"
    STOPPED = "stopped by you"
    CRASHED = "crashed"
    STUCK = "does not stop"
    STARTING = "starting"  # its constructor has not returned

    @property
    def is_running(self) -> bool:
        """True for a node that can be stopped and not be started."""
        return self in (Life.UP, Life.STARTING)


class Hosted(NamedTuple):
    """A node that this process hosts."""

    name: str  # fully qualified
    life: Life = Life.UP
    # what a callback raised; of a node that is up: why its new text does not run; of one that
    # starts: the line where its constructor is
    error: str = ""
    traceback: str = ""
    serves: tuple[str, ...] = ()  # services and actions: a second one of its kind would as well
    file: str = ""  # of the user's own, by its name
    saved: float = 0.0  # Unix time of the file's text that runs


@dataclass(frozen=True)
class Event:
    """A line of the log, of a node or the console's own. Times are when it was received."""

    time: float
    level: str  # DEBUG INFO WARN ERROR FATAL, or one of OWN_LEVELS
    source: str
    text: str
    command: str = ""  # the ros2 command line that does the same
    count: int = 1  # how many alike it stands for
    first: float = 0.0  # when the first of them was
    number: int = 0  # of the first of them: tells events apart
    audit_record: AuditRecord | None = None  # what was done, where somebody did something


class StopAnswer(Enum):
    """The answer so far to a STOP that is not confirmed; the value is the word for it."""

    AWAITED = ""
    NONE = "no answer"  # from every server: it is sent again
    NOT_SENT = "NOT SENT"
    REFUSED = "REFUSED"
    UNCONFIRMED = "ANSWERED, NOT CONFIRMED"


class OpenStop(NamedTuple):
    """A STOP that was asked for and that the robot has not confirmed."""

    asked: float  # monotonic s
    answer: StopAnswer = StopAnswer.AWAITED
    why: str = ""  # more about that


class Latch(Enum):
    """The state of the last STOP that the robot has confirmed or reported."""

    NONE = "none"  # there was none, or it was released
    HELD = "held"
    UNCERTAIN = "uncertain"  # the node that held it has left, or was started anew


class Snapshot(NamedTuple):
    """Everything a screen can show, at one moment."""

    file: RobotFile = RobotFile()  # of the robot
    battery: Battery = Battery()
    motion: Motion = Motion()
    gauges: tuple[Reading, ...] = ()
    goal: Goal | None = None
    running: int = 0  # goals
    history: tuple[Goal, ...] = ()  # ended goals, newest first
    parameters: tuple[Parameter, ...] = ()
    nodes: tuple[NodeState, ...] = ()
    offered: frozenset[str] = frozenset()  # which names of the robot file somebody serves
    events: tuple[Event, ...] = ()  # newest last
    charge: tuple[tuple[float, float], ...] = ()  # (monotonic s, %) since it last turned
    open_stop: OpenStop | None = None
    latch: Latch = Latch.NONE
    latch_lost: str = ""  # why an UNCERTAIN one is not certain
    latch_time: float = 0.0  # Unix time of that STOP
    released: float | None = None  # when the robot confirmed a release, monotonic s
    moves_on: bool = False  # the robot, though it has confirmed a STOP
    still_running_after_stop: tuple[str, ...] = ()  # goals that run on after the answer to a STOP
    namespace: str = "/"  # of the robot that is operated
    faults: Mapping[str, str] = _NOTHING  # why one of these is not used
    publishers: Mapping[str, tuple[str, ...]] = _NOTHING  # nodes, by topic
    twice: tuple[str, ...] = ()  # names that several nodes have
    several: Mapping[str, tuple[str, ...]] = _NOTHING  # nodes of a service or action with several
    has_clock: bool = False  # somebody publishes /clock
    elsewhere: tuple[str, ...] = ()  # namespaces with nodes, beside this one
    consoles: tuple[str, ...] = ()  # the others of this namespace: user_host_pid
    forms: Mapping[str, tuple[TypedField, ...]] = _NOTHING  # by id of the goal
    actions: Mapping[str, tuple[str, ...]] = _NOTHING  # types, of all served
    services: Mapping[str, tuple[str, ...]] = _NOTHING  # types, of all served
    resources: tuple[Resource, ...] = ()  # all but ROS's own
    message_rates: Mapping[str, MessageRate] = _NOTHING  # of the topics that the console hears

    @property
    def is_stopped(self) -> bool:
        """True when the robot says so, and while a STOP is not confirmed, or no longer certain.

        Also while a confirmed STOP holds that the robot does not report.
        """
        in_doubt = self.open_stop is not None or self.latch is Latch.UNCERTAIN
        return in_doubt or self.says_stopped or self.stop_holds

    @property
    def stop_holds(self) -> bool:
        """True while a STOP that was confirmed is not released, of a robot that never reports it.

        Where nothing releases a STOP, it is over as soon as it is confirmed.
        """
        stop = self.file.stop
        is_latched = self.latch is Latch.HELD and stop is not None and bool(stop.release)
        return is_latched and self.motion.stopped is None

    @property
    def is_at_rest(self) -> bool:
        """True when it is stopped: by its own word, or behind a STOP of ours and not moving."""
        return self.says_stopped or (self.stop_holds and not self.motion.moving)

    @property
    def says_stopped(self) -> bool:
        """True when the robot said so, by a node that is still there, and confirmed no release."""
        heard, released = self.motion.received, self.released
        is_past = heard is not None and released is not None and heard <= released
        return bool(self.motion.stopped) and not is_past and self.latch is not Latch.UNCERTAIN

    @property
    def running_goal(self) -> Goal | None:
        """The goal, while it runs."""
        return self.goal if self.goal is not None and self.goal.is_running else None

    def full(self, name: str) -> str:
        """Return the full name of what the robot file names so."""
        return in_namespace(self.namespace, name)

    def unavailable(self, name: str) -> str:
        """Return why a service or action of the robot file cannot be used; empty if it can."""
        return self.faults.get(name, "") if name in self.offered else not_offered(name)

    @property
    def absent(self) -> frozenset[str]:
        """The names of the robot file that nobody serves, or not as the file says."""
        actions = (kind.action for kind in self.file.goals)
        names = (*self.file.topics, *self.file.services, *actions)
        return frozenset(name for name in names if self.unavailable(name))

    def parameter(self, name: str) -> Parameter | None:
        """Return the first parameter of that name on any node; None: there is none."""
        return next((p for p in self.parameters if p.name == name), None)

    @property
    def threshold(self) -> float | None:
        """The charge (%) below which it is low, as the robot has it; None: it says nothing."""
        low = None if self.file.battery is None else self.file.battery.low
        if isinstance(low, ParameterRef):
            return linked(self.parameters, self.namespace, low, 0.0, 100.0)
        return low

    @property
    def time_factor(self) -> float | None:
        """The simulated seconds in a real one; None: one, or not reported."""
        link = None if self.file.motion is None else self.file.motion.time_factor
        found = None if link is None else linked(self.parameters, self.namespace, link, 0.0)
        return None if found == 1.0 else found

    def limit(self, given: Limit) -> float | None:
        """Return a limit of what may be typed, as the robot has it now; None: none is known."""
        if isinstance(given, ParameterRef):
            return linked(self.parameters, self.namespace, given)
        return given

    def form(self, kind: GoalKind) -> Mapping[str, FormField]:
        """Return the form of a goal with the limits that hold now."""
        return {
            path: replace(given, low=self.limit(given.low), high=self.limit(given.high))
            for path, given in kind.form.items()
        }


def not_offered(name: str) -> str:
    """Return the text for a service or an action that no node offers."""
    return f"{name} is not offered by any node"


def logger_node(logger: str) -> str:
    """Return the full name of the node that has a logger of that name (`north.lamp`)."""
    return "/" + logger.replace(".", "/")


def in_namespace(namespace: str, name: str) -> str:
    """Return the full name of a name in a namespace; one that begins with `/` is full already."""
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def linked(
    parameters: Iterable[Parameter],
    namespace: str,
    link: ParameterRef,
    low: float = -_FARTHEST,
    high: float = _FARTHEST,
) -> float | None:
    """Return the number that a reference leads to; None if it leads to none within low .. high."""
    wanted = (in_namespace(namespace, link.node), link.parameter)
    for parameter in parameters:
        if (parameter.node, parameter.name) == wanted:
            found = number(parameter.value, low, high)
            return link.otherwise if found is None else found
    return link.otherwise
