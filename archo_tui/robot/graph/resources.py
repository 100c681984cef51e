"""The topics, services and actions on the graph, and the nodes that have them. ROS thread only.

A question about one topic or service takes rclpy a time that grows with the graph (0.3 ms beside
4,000 topics), a question about one node does not (0.03 ms, rclpy 7.1 on Fast DDS). So nodes are
asked, a few at each poll, and all of them when a name came or went.
"""

from __future__ import annotations

from collections import OrderedDict, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import Generic, NamedTuple, TypeVar

from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # It has no public name.
from rclpy.node import Node

from archo_tui.robot.graph.endpoints import mismatches
from archo_tui.robot.state.graph import ACTION, SERVICE, TOPIC, Resource, in_namespace

_OF_EVERY_NODE = ("/rosout", "/parameter_events")
SEND = "/_action/send_goal"

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
        self._ends: dict[str, _TopicEnds] = {}  # The answers, by topic.
        self._counted: set[str] = set()  # Services that are served, though no node names them.
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
            for topic in matched & self._ends.keys()
            if publishers[topic] != self._publishers.get(topic)
            or subscribers[topic] != self._subscribers.get(topic)
        )
        wanted = {*self._named.services, *(f"{name}{SEND}" for name in self._named.actions)}
        unserved = wanted - servers.keys()
        self._asked_names.set_items(matched | unpublished | unserved)
        self._ends = {
            topic: ends for topic, ends in self._ends.items() if topic in matched | unpublished
        }
        self._counted &= unserved
        self._publishers, self._subscribers, self._servers = publishers, subscribers, servers

    def _ask_about_names(self, has_time: Callable[[], bool]) -> bool:
        """Ask about the names that are due; return True if an answer differs from the last."""
        if self._is_partly_asked:  # The other nodes will tell of most names.
            return False
        before = dict(self._ends), set(self._counted)
        for name in self._asked_names.take_due():
            if name in self._named.topics:
                self._ends[name] = self._ask_about_topic(name)
            elif self._node.count_services(name):  # Of two nodes with one name ROS names only one.
                self._counted.add(name)
            else:
                self._counted.discard(name)
            if not has_time():
                break
        return before != (self._ends, self._counted)

    def _ask_about_topic(self, topic: str) -> _TopicEnds:
        publishers = self._node.get_publishers_info_by_topic(topic)
        nodes = frozenset(in_namespace(i.node_namespace, i.node_name) for i in publishers)
        subscriptions = self._node.get_subscriptions_info_by_topic(topic) if nodes else ()
        return _TopicEnds(nodes, mismatches(topic, publishers, subscriptions, self._console))

    def _list(self) -> None:
        """Rebuild the public attributes from the answers."""
        topics, services, actions = self._named
        served = self._servers.keys() | self._counted
        self.services = {name: types for name, types in services.items() if name in served}
        self.actions = {name: types for name, types in actions.items() if f"{name}{SEND}" in served}
        self.all = (
            *(self._topic(name, topics[name]) for name in sorted(topics)),
            *_resources(SERVICE, self.services, lambda name: _sorted(self._servers, name)),
            *_resources(ACTION, self.actions, lambda name: _sorted(self._servers, name + SEND)),
        )

    def _topic(self, name: str, types: tuple[str, ...]) -> Resource:
        ends = self._ends.get(name, _TopicEnds(frozenset(), ()))
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
