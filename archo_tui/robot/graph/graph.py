"""The nodes on the graph, what they offer, and how often their messages come. ROS thread only."""

from __future__ import annotations

import contextlib
import time
from collections import Counter, OrderedDict, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any, Generic, NamedTuple, TypeVar

from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # It has no public name.
from rclpy.node import Node

from archo_tui.robot.clients import author
from archo_tui.robot.graph.endpoints import mismatches
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.graph import (
    ACTION,
    SERVICE,
    TOPIC,
    NodeState,
    Resource,
    in_namespace,
    node_of,
    node_states,
)
from archo_tui.robot_file.model import RobotFile
from archo_tui.ros.names import package_of

SHARE = 0.05  # The share of the ROS thread's time that polls take at most.
_SLICE = 0.02  # Seconds of CPU time in a poll for details; a STOP waits until the poll is over.
SEND = "/_action/send_goal"
_OF_NODES = ("rcl_interfaces", "type_description_interfaces")  # Services that every node has.


class Graph:
    """The robot's part of the graph as it was at the last poll.

    Names are full names, except those that come from the robot file.
    """

    def __init__(self, node: Node, robot: RobotFile) -> None:
        self._node = node
        self._topics = robot.shown_topics
        self._services = robot.services
        self._actions = tuple(dict.fromkeys(kind.action for kind in robot.goals))
        stop = () if robot.stop is None else (robot.stop.service,)
        self._alone = (*stop, *self._actions)  # Each should have a single server.
        self.namespace = node.get_namespace()  # The robot's namespace.
        self._below = in_namespace(self.namespace, "")
        # The nodes in the namespace, or below it, that are not hidden; how many have each name.
        self.nodes: dict[str, int] = {}
        # The types of each service in all namespaces, also of one that has only clients.
        self.services: dict[str, list[str]] = {}
        # The names of the robot file for which a node publishes or serves something.
        self.offered: frozenset[str] = frozenset()
        # The nodes that publish each topic of the robot file; one that did last, if none does.
        self.publishers: dict[str, tuple[str, ...]] = {}
        # The nodes that serve each action of the robot file; an empty set if none does.
        self.servers: dict[str, frozenset[str]] = {}
        # The types of each action of the robot file.
        self.action_types: dict[str, tuple[str, ...]] = {}
        # The nodes of STOP's service and of each action that several nodes serve: one request would
        # reach all of them.
        self.duplicates: dict[str, tuple[str, ...]] = {}
        self.has_clock = False  # True if a node publishes simulated time on /clock.
        self.other_namespaces: tuple[str, ...] = ()  # The other namespaces that have nodes.
        # The other consoles in this namespace, as `anna_lab_4711`.
        self.consoles: tuple[str, ...] = ()
        # Those of the other consoles that publish no audit records.
        self.silent_consoles: frozenset[str] = frozenset()
        # The seconds to wait after a poll, so that polls take no more time than SHARE.
        self.rest = 0.0
        self.listed = Resources(node, self.is_ours)  # What the robot offers.
        # The robot's services and actions with their types, also those that have only clients.
        self._named_services: dict[str, tuple[str, ...]] = {}
        self._named_actions: dict[str, tuple[str, ...]] = {}
        self._logged: dict[str, float] = {}  # By node, in monotonic seconds.
        self._topic_rates: dict[str, MessageRate] = {}

    def poll(self) -> bool:
        """Read the graph into the attributes; return True if what a snapshot shows has changed.

        The QoS and the nodes of topics, services and actions are read a part at a time: on a large
        graph they are complete only after several polls.
        """
        begun, before = time.thread_time(), (self.nodes.keys(), self.shown())
        self._poll()
        self.rest = (time.thread_time() - begun) / SHARE
        return before != (self.nodes.keys(), self.shown())

    def shown(self) -> dict[str, Any]:
        """Return the fields of a snapshot that a poll finds."""
        return {
            "offered": self.offered,
            "publishers": {t: nodes for t, nodes in self.publishers.items() if len(nodes) > 1},
            "duplicate_nodes": tuple(name for name, count in self.nodes.items() if count > 1),
            "duplicate_servers": self.duplicates,
            "has_clock": self.has_clock,
            "other_namespaces": self.other_namespaces,
            "consoles": self.consoles,
            "actions": self.listed.actions,
            "services": self.listed.services,
            "resources": self.listed.all,
        }

    def recheck_service(self, service: str) -> None:
        """Add a service to `offered` if a server is there now; it is quick, as a STOP waits."""
        if self._node.count_services(service):
            self._read_services()
            self.offered |= {service}

    def knows_console(self, console: str) -> bool:
        """Return True if another console of a name is here; look again if it was not by now.

        One that only sends a STOP comes and goes between two polls.
        """
        if console not in self.consoles:
            pairs = self._node.get_node_names_and_namespaces()
            self._find_consoles(_full(*pair) for pair in pairs)
        return console in self.consoles

    def _find_consoles(self, found: Iterable[str]) -> None:
        own = self._node.get_fully_qualified_name()
        here = [name for name in found if name.rpartition("/")[0] == self._below[:-1]]
        self.consoles = tuple(sorted(filter(None, (author(n) for n in here if n != own))))

    def _poll(self) -> None:
        pairs = self._node.get_node_names_and_namespaces()
        found = Counter(_full(*pair) for pair in pairs)
        self.nodes = {name: found[name] for name in sorted(found) if self.is_ours(name)}
        others = {name.rpartition("/")[0] or "/" for name in found if not is_hidden(name)}
        self.other_namespaces = tuple(sorted(others - {self.namespace}))
        self._find_consoles(found)
        self.silent_consoles = frozenset(self.consoles)
        if self.consoles:
            self.silent_consoles -= self._record_publishers()
        self.has_clock = self._node.count_publishers("/clock") > 0
        self._read_services()
        # A name may be that of a client, as of our own, so the servers are counted.
        count = self._node.count_services
        offered = {name for name in self._services if count(name)}
        for topic in self._topics:
            nodes = sorted(map(node_of, self._node.get_publishers_info_by_topic(topic)))
            offered |= {topic} if nodes else set()
            self.publishers[topic] = tuple(nodes) or self.publishers.get(topic, ())[:1]
        for action in self._actions:
            if count(f"{action}/_action/send_goal"):
                offered.add(action)
            self._read_action(action)
        end = time.thread_time() + _SLICE
        self.listed.poll(
            frozenset(pairs),
            self._named_services,
            self._named_actions,
            lambda: time.thread_time() < end,
        )
        servers = {name: self.duplicate_servers(name) for name in self._alone}
        self.duplicates = {name: nodes for name, nodes in servers.items() if nodes}
        self.offered = frozenset(offered)

    def _record_publishers(self) -> set[str]:
        infos = self._node.get_publishers_info_by_topic(audit_records.TOPIC)
        return {author(node_of(info)) for info in infos}

    def _read_action(self, action: str) -> None:
        infos = self._node.get_publishers_info_by_topic(f"{action}/_action/feedback")
        self.servers[action] = frozenset(node_of(info) for info in infos)
        self.action_types[action] = _action_types(infos)

    def _read_services(self) -> None:
        """Read the types of all services, and those of the robot's own services and actions."""
        services = dict(self._node.get_service_names_and_types())
        if services == self.services:
            return
        self.services = services
        self._named_services, self._named_actions = {}, {}
        for name, kinds in services.items():
            action = name.removesuffix(SEND)
            if not self.is_ours(action):
                continue
            if action != name:
                types = sorted(kind.removesuffix("_SendGoal") for kind in kinds)
                self._named_actions[action] = tuple(types)
            elif not is_of_every_node(kinds):
                self._named_services[name] = tuple(kinds)

    def is_published(self, topic: str) -> bool:
        """Return True if a node publishes a topic now, by its full name; this asks the graph."""
        return bool(self._node.count_publishers(topic))

    def is_ours(self, name: str) -> bool:
        """Return True for a full name in the robot's namespace, or below it, that is not hidden."""
        return name.startswith(self._below) and not is_hidden(name)

    def duplicate_servers(self, name: str) -> tuple[str, ...]:
        """Return the nodes that serve a service or an action now; empty if fewer than two do."""
        found = []
        for service in (name, f"{name}{SEND}"):
            count = self._node.count_services(service)
            if count > 1:
                nodes = [node for node, _ in self._servers(service)]
                # Of two nodes with one name ROS names only one.
                found += [*nodes, *[nodes[-1] if nodes else name] * (count - len(nodes))]
        return tuple(found)

    def holders(self, service: str) -> dict[str, frozenset[bytes]]:
        """Return the nodes that serve a service now, with ids that change at a restart of the node.

        The ids are those of the node's publishers of /parameter_events. Every node of rclcpp and
        rclpy has one; another node has no ids, and its restart is not noticed.
        """
        ids = defaultdict[str, set[bytes]](set)
        for info in self._node.get_publishers_info_by_topic("/parameter_events"):
            ids[node_of(info)].add(bytes(info.endpoint_gid))
        return {node: frozenset(ids[node]) for node, _ in self._servers(service)}

    def served_types(self, name: str) -> list[str]:
        """Return the types with which nodes serve a service now, sorted; every node is asked."""
        return sorted({kind for _, kinds in self._servers(name) for kind in kinds})

    def _servers(self, service: str) -> list[tuple[str, list[str]]]:
        """Ask every node on the graph for its services; return those that serve a service."""
        found, full = [], str(self._node.resolve_service_name(service))
        for node, namespace in sorted(set(self._node.get_node_names_and_namespaces())):
            with contextlib.suppress(NodeNameNonExistentError):  # It has left meanwhile.
                served = dict(self._node.get_service_names_and_types_by_node(node, namespace))
                if full in served:
                    found.append((_full(node, namespace), served[full]))
        return found

    def on_topic_message(self, topic: str, now: float) -> None:
        """Count a message for the rate of a topic of the robot file."""
        rate = self._topic_rates.get(topic)
        self._topic_rates[topic] = MessageRate(now) if rate is None else rate.with_message_at(now)

    def on_log_line(self, name: str, now: float) -> None:
        """Record that a node was heard by a log line; a name that is not in `nodes` is ignored."""
        if name in self.nodes:
            self._logged[name] = now

    def node_states(self) -> tuple[NodeState, ...]:
        """Return for every node when it was last heard, and its rate, sorted by name."""
        rates = self._topic_rates.items()
        # A topic of several nodes tells of the first.
        by_node = ((next(iter(self.publishers.get(t, ())), ""), rate) for t, rate in rates)
        return tuple(node_states(self.nodes, self._logged, by_node).values())

    def message_rates(self) -> dict[str, MessageRate]:
        """Return the rate of each topic of the robot file that was received, by its full name."""
        return {
            in_namespace(self.namespace, topic): rate for topic, rate in self._topic_rates.items()
        }


def is_of_every_node(types: Sequence[str]) -> bool:
    """Return True for the types of a service that every node has, as for its parameters."""
    return package_of(types[0]) in _OF_NODES


def is_hidden(name: str) -> bool:
    """Return True if a part of a full name begins with `_`, as in those of ROS's tools."""
    return "/_" in name


def _action_types(infos: Any) -> tuple[str, ...]:
    return tuple(sorted({info.topic_type.removesuffix("_FeedbackMessage") for info in infos}))


def _full(name: str, namespace: str) -> str:
    return in_namespace(namespace, name)


# The topics, services and actions.
#
# A question about one topic or service takes rclpy a time that grows with the graph (0.3 ms beside
# 4,000 topics), a question about one node does not (0.03 ms, rclpy 7.1 on Fast DDS). So nodes are
# asked, a few at each poll, and all of them when a name came or went.

_OF_EVERY_NODE = ("/rosout", "/parameter_events")

Pair = tuple[str, str]  # The name and the namespace of a node.
Types = Mapping[str, tuple[str, ...]]  # By full name.


class _NodeNames(NamedTuple):
    """The full names of the topics and services of one node."""

    publishes: frozenset[str]
    subscribes: frozenset[str]
    serves: frozenset[str]


class _TopicEnds(NamedTuple):
    """The answer to a question about one topic."""

    # The full names of its publishers' nodes, also of nodes that ROS cannot name.
    publishers: frozenset[str]
    # A text for each subscribing node that does not get or may misread the messages.
    mismatches: tuple[str, ...]


class _Named(NamedTuple):
    """The robot's topics, services and actions on the graph: the types by full name."""

    topics: Types
    services: Types
    actions: Types


class Resources:
    """The robot's topics, services and actions, asked of the graph a few at each poll."""

    def __init__(self, node: Node, is_ours: Callable[[str], bool]) -> None:
        self._node, self._is_ours = node, is_ours
        self._console = node.get_fully_qualified_name()
        self._named = _Named({}, {}, {})
        self._nodes: PollSchedule[Pair] = PollSchedule()
        self._names_of: dict[Pair, _NodeNames] = {}
        self._is_partly_asked = False  # True if there was no time for all nodes that were due.
        # The names about which questions are needed: topics with publishers and subscriptions, and
        # whatever no known node publishes or serves.
        self._asked_names: PollSchedule[str] = PollSchedule()
        # The answers: of a service True if it is served, though no node names it.
        self._answers: dict[str, _TopicEnds | bool] = {}
        # The nodes of each topic and service.
        self._publishers: Mapping[str, AbstractSet[str]] = {}
        self._subscribers: Mapping[str, AbstractSet[str]] = {}
        self._servers: Mapping[str, AbstractSet[str]] = {}
        # All of them: topics, services, actions, each sorted by name; the same object until
        # something changes.
        self.all: tuple[Resource, ...] = ()
        self.services: Types = {}  # The types of each service that is served, by full name.
        self.actions: Types = {}  # The types of each action that is served, by full name.

    def poll(
        self,
        nodes: AbstractSet[Pair],
        services: Types,
        actions: Types,
        has_time: Callable[[], bool],
    ) -> None:
        """Ask the graph what is due, and update the attributes if an answer changed.

        If a name came or went, all nodes are due; otherwise each node is due within 30 polls.
        """
        topics = {
            name: tuple(types)
            for name, types in self._node.get_topic_names_and_types()
            if self._is_ours(name) and name not in _OF_EVERY_NODE
        }
        named = _Named(topics, services, actions)
        is_changed = named != self._named
        self._named = named
        self._nodes.set_items(nodes)
        if is_changed:  # A new name does not tell which node has it.
            self._nodes.prioritize(nodes)
        if self._ask_nodes(nodes, has_time) or is_changed:
            is_changed = True
            self._sort_by_name()
        if self._ask_about_names(has_time) or is_changed:
            self._list()

    def _ask_nodes(self, nodes: AbstractSet[Pair], has_time: Callable[[], bool]) -> bool:
        """Ask the nodes that are due for their names; return True if any of these changed."""
        left = self._names_of.keys() - nodes
        for pair in left:
            del self._names_of[pair]
        is_changed, unknown = bool(left), []
        self._is_partly_asked = False
        for pair in self._nodes.take_due():
            try:
                has = self._ask_node(*pair)
            except NodeNameNonExistentError:  # It has just left, or just come.
                unknown.append(pair)
                continue
            is_changed = is_changed or self._names_of.get(pair) != has
            self._names_of[pair] = has
            if not has_time():
                self._is_partly_asked = True
                break
        self._nodes.prioritize(unknown)
        return is_changed

    def _ask_node(self, name: str, namespace: str) -> _NodeNames:
        node = self._node
        return _NodeNames(
            _names(node.get_publisher_names_and_types_by_node(name, namespace)),
            _names(node.get_subscriber_names_and_types_by_node(name, namespace)),
            _names(node.get_service_names_and_types_by_node(name, namespace)),
        )

    def _sort_by_name(self) -> None:
        """Collect the nodes of each name, and schedule the names that need more questions."""
        publishers, subscribers, servers = (defaultdict[str, set[str]](set) for _ in range(3))
        for (name, namespace), has in self._names_of.items():
            node = in_namespace(namespace, name)
            for topic in has.publishes:
                publishers[topic].add(node)
            for topic in has.subscribes if "/_" not in node or node == self._console else ():
                subscribers[topic].add(node)
            for service in has.serves:
                servers[service].add(node)
        topics = self._named.topics.keys()
        matched = topics & publishers.keys() & subscribers.keys()
        unpublished = topics - publishers.keys()
        self._asked_names.prioritize(
            topic
            for topic in matched & self._answers.keys()
            if publishers[topic] != self._publishers.get(topic)
            or subscribers[topic] != self._subscribers.get(topic)
        )
        wanted = {*self._named.services, *(f"{name}{SEND}" for name in self._named.actions)}
        unserved = wanted - servers.keys()
        asked = matched | unpublished | unserved
        self._asked_names.set_items(asked)
        self._answers = {name: found for name, found in self._answers.items() if name in asked}
        self._publishers, self._subscribers, self._servers = publishers, subscribers, servers

    def _ask_about_names(self, has_time: Callable[[], bool]) -> bool:
        """Ask about the names that are due; return True if an answer differs from the last."""
        if self._is_partly_asked:  # The other nodes will tell of most names.
            return False
        before = dict(self._answers)
        for name in self._asked_names.take_due():
            is_topic = name in self._named.topics
            # Of two nodes with one name ROS names only one.
            count = self._node.count_services
            self._answers[name] = self._ask_about_topic(name) if is_topic else count(name) > 0
            if not has_time():
                break
        return before != self._answers

    def _ask_about_topic(self, topic: str) -> _TopicEnds:
        publishers = self._node.get_publishers_info_by_topic(topic)
        nodes = frozenset(map(node_of, publishers))
        subscriptions = self._node.get_subscriptions_info_by_topic(topic) if nodes else ()
        return _TopicEnds(nodes, mismatches(topic, publishers, subscriptions, self._console))

    def _list(self) -> None:
        """Rebuild the public attributes from the answers."""
        topics, services, actions = self._named
        served = self._servers.keys() | {n for n, answer in self._answers.items() if answer is True}
        self.services = {name: types for name, types in services.items() if name in served}
        self.actions = {name: types for name, types in actions.items() if f"{name}{SEND}" in served}
        self.all = (
            *(self._topic(name, topics[name]) for name in sorted(topics)),
            *_resources(SERVICE, self.services, lambda name: _sorted(self._servers, name)),
            *_resources(ACTION, self.actions, lambda name: _sorted(self._servers, name + SEND)),
        )

    def _topic(self, name: str, types: tuple[str, ...]) -> Resource:
        answer = self._answers.get(name)
        ends = answer if isinstance(answer, _TopicEnds) else _TopicEnds(frozenset(), ())
        nodes = self._publishers.get(name, ends.publishers)
        return Resource(TOPIC, name, types, tuple(sorted(nodes)), ends.mismatches)


def _names(found: Iterable[tuple[str, object]]) -> frozenset[str]:
    return frozenset(name for name, _ in found)


def _sorted(nodes: Mapping[str, AbstractSet[str]], name: str) -> tuple[str, ...]:
    return tuple(sorted(nodes.get(name, ())))


def _resources(
    kind: str, found: Types, nodes: Callable[[str], tuple[str, ...]]
) -> Iterator[Resource]:
    for name in sorted(found):
        yield Resource(kind, name, found[name], nodes(name))


T = TypeVar("T")

PERIOD = 30  # Each item is due at least once in so many polls, of which there is one a second.
LEAST = 10  # Items that are due at each poll, so that few items are all due each time.


class PollSchedule(Generic[T]):
    """A queue of items to poll: urgent ones first, then those that have waited longest."""

    def __init__(self) -> None:
        self._urgent: OrderedDict[T, None] = OrderedDict()
        self._in_turn: OrderedDict[T, None] = OrderedDict()  # The longest wait comes first.

    def set_items(self, items: AbstractSet[T]) -> None:
        """Replace the set of items: new ones become urgent, and missing ones are dropped."""
        for gone in self._in_turn.keys() - items:
            del self._in_turn[gone]
            self._urgent.pop(gone, None)
        new = items - self._in_turn.keys()
        self._in_turn.update(dict.fromkeys(new))
        self.prioritize(new)

    def prioritize(self, items: Iterable[T]) -> None:
        """Make items urgent for the next poll; they must be among those that were set."""
        self._urgent.update(dict.fromkeys(items))

    def take_due(self) -> Iterator[T]:
        """Yield all urgent items, then those that wait longest, up to a thirtieth of all or ten."""
        urgent: Collection[T] = tuple(self._urgent)
        for item in urgent:
            del self._urgent[item]
            self._in_turn.move_to_end(item)
            yield item
        share = max(LEAST, -(-len(self._in_turn) // PERIOD)) - len(urgent)
        for _ in range(min(share, len(self._in_turn))):
            item = next(iter(self._in_turn))
            self._in_turn.move_to_end(item)
            yield item
