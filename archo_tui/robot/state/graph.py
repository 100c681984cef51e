"""Nodes, topics, services, actions and parameters as they are shown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from enum import Enum, auto
from typing import Any, NamedTuple

from archo_tui.robot.messages.values import number, same
from archo_tui.robot_file.model import ParameterRef

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
    """A node on the graph.

    Recordings have the names of the attributes.
    """

    name: str
    heard: float | None = None  # When its last message or log line came, in monotonic seconds.
    rate: float | None = None  # The rate in Hz of its messages that the console reads.
    # The state of a managed node, as `inactive`, or `inactive, no answer` if it did not answer the
    # last question; "" if it is not managed, or was not asked yet.
    lifecycle: str = ""

    def is_silent(self, now: float) -> bool:
        """Return True if nothing was received for three intervals of its rate, at least 2.5 s.

        Before the first message, or without a rate, it is False.
        """
        if self.heard is None or not self.rate:
            return False
        return now - self.heard > max(3 / self.rate, 2.5)


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
    """A topic, a service or an action, and the nodes that publish or serve it.

    Recordings have the names of the attributes.
    """

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
    """A parameter of a node, as the node has reported it.

    Recordings have the names of the attributes.
    """

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

    @property
    def is_running(self) -> bool:
        """True for UP and STARTING: the node can be stopped and not be started."""
        return self in (Life.UP, Life.STARTING)


class Hosted(NamedTuple):
    """A node that this process hosts.

    Recordings have the names of the attributes.
    """

    name: str
    life: Life = Life.UP
    error: str = ""  # What a callback raised.
    traceback: str = ""  # The traceback of `error`, or "".
    serves: tuple[str, ...] = ()  # The full names of the services and actions that it serves.
    file: str = ""  # The name of the user's file that it comes from; "" for a node of a package.
    saved: float = 0.0  # The Unix time at which the text that runs was saved.
