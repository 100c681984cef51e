"""The nodes on the graph, their parameters, and what they offer."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from archo_tui.base.clock import Monotonic
from archo_tui.robot.messages.period import MessageRate, is_silent
from archo_tui.robot.messages.values import number, same
from archo_tui.robot_file.model import ParameterRef

MASK = "***"  # In place of a secret value.


def in_namespace(namespace: str, name: str) -> str:
    """Return a name of the robot file as a full name in a namespace."""
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def node_of(info: Any) -> str:
    """Return the full name of the node of a publisher or subscription, as rclpy tells of it."""
    return in_namespace(info.node_namespace, info.node_name)


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
        """Return True if nothing was received for three intervals of its rate, at least 2.5 s."""
        return is_silent(self.heard, 1 / self.rate if self.rate else None, now, None)


def node_states(
    names: Iterable[str],
    logged: Mapping[str, Monotonic],
    rates: Iterable[tuple[str, MessageRate]],
) -> dict[str, NodeState]:
    """Return by name when each node was heard last, and the rate of its most frequent topic."""
    found, by_node = dict[str, NodeState](), defaultdict[str, list[MessageRate]](list)
    for name, rate in rates:
        by_node[name].append(rate)
    for name in names:
        heard = max((rate.heard for rate in by_node[name]), default=0.0)
        hertz = max((rate.hertz_at(heard) or 0.0 for rate in by_node[name]), default=0.0)
        last = max(heard, logged.get(name, 0.0))
        found[name] = NodeState(name, last or None, hertz or None)
    return found


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
