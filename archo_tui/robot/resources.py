"""The topics, services and actions on the graph, and the nodes that have them. ROS thread only.

To ask for a topic or a service by its name takes rclpy a time that grows with the graph (0.3 ms
beside 4,000 topics), to ask a node what it has does not (0.03 ms, rclpy 7.1 on Fast DDS). So nodes
are asked, a few at each look and all of them when a name came or went.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import NamedTuple

from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # rclpy has no public name for it
from rclpy.node import Node

from archo_tui.robot.endpoints import mismatches
from archo_tui.robot.state import ACTION, SERVICE, TOPIC, Resource, in_namespace
from archo_tui.robot.sweep import Sweep

_OF_EVERY_NODE = ("/rosout", "/parameter_events")
SEND = "/_action/send_goal"

Pair = tuple[str, str]  # name and namespace of a node
Types = Mapping[str, tuple[str, ...]]  # by name


class _Has(NamedTuple):
    """The full names of what one node has."""

    publishes: frozenset[str]
    subscribes: frozenset[str]
    serves: frozenset[str]


class _Ends(NamedTuple):
    """The ends of a topic, as found by its name."""

    publishers: frozenset[str]  # full names of nodes; those that ROS has no name for, too
    mismatches: tuple[str, ...]


class _Named(NamedTuple):
    """The names on the graph, each with its types; of services there may be clients only."""

    topics: Types
    services: Types
    actions: Types


class Resources:
    """Asks nodes what they have, and topics whether their ends fit, within the time it is given."""

    def __init__(self, node: Node, is_ours: Callable[[str], bool]) -> None:
        """`is_ours(name)` tells what belongs to the robot."""
        self._node, self._is_ours = node, is_ours
        self._console = node.get_fully_qualified_name()
        self._named = _Named({}, {}, {})
        self._nodes: Sweep[Pair] = Sweep()
        self._has: dict[Pair, _Has] = {}
        self._is_partly_asked = False  # there was no time for all nodes that were due
        # topics with publishers and subscriptions, and what no node that is known publishes, serves
        self._names: Sweep[str] = Sweep()
        self._ends: dict[str, _Ends] = {}  # by topic, of those
        self._counted: set[str] = set()  # services that somebody serves, though no node says so
        self._publishers: Mapping[str, AbstractSet[str]] = {}  # nodes by topic, as those below
        self._subscribers: Mapping[str, AbstractSet[str]] = {}
        self._servers: Mapping[str, AbstractSet[str]] = {}
        self.all: tuple[Resource, ...] = ()
        self.services: Types = {}  # that somebody serves
        self.actions: Types = {}

    def look(
        self,
        nodes: AbstractSet[Pair],
        services: Types,
        actions: Types,
        has_time: Callable[[], bool],
    ) -> None:
        """Look again.

        Args:
            nodes: All that are on the graph.
            services: By name; there may be clients only, as for `actions`.
            actions: By name.
            has_time: Returns False once nothing more is to be asked at this look; what is left
                then comes at the next ones.
        """
        topics = {
            name: tuple(types)
            for name, types in self._node.get_topic_names_and_types()
            if self._is_ours(name) and name not in _OF_EVERY_NODE
        }
        named = _Named(topics, services, actions)
        is_changed = named != self._named
        self._named = named
        self._nodes.follow(nodes)
        if is_changed:  # whose it is, no name tells
            self._nodes.hurry(nodes)
        if self._ask_nodes(nodes, has_time) or is_changed:
            is_changed = True
            self._sort_by_name()
        if self._ask_for_names(has_time) or is_changed:
            self._list()

    def _ask_nodes(self, nodes: AbstractSet[Pair], has_time: Callable[[], bool]) -> bool:
        """Ask the nodes that are due what they have; True when one has something else."""
        left = self._has.keys() - nodes
        for pair in left:
            del self._has[pair]
        is_changed, unknown = bool(left), []
        self._is_partly_asked = False
        for pair in self._nodes.due():
            try:
                has = self._ask(*pair)
            except NodeNameNonExistentError:  # it has just left, or just come
                unknown.append(pair)
                continue
            is_changed = is_changed or self._has.get(pair) != has
            self._has[pair] = has
            if not has_time():
                self._is_partly_asked = True
                break
        self._nodes.hurry(unknown)
        return is_changed

    def _ask(self, name: str, namespace: str) -> _Has:
        node = self._node
        return _Has(
            _names(node.get_publisher_names_and_types_by_node(name, namespace)),
            _names(node.get_subscriber_names_and_types_by_node(name, namespace)),
            _names(node.get_service_names_and_types_by_node(name, namespace)),
        )

    def _sort_by_name(self) -> None:
        """Sort what the nodes have by its names, and follow the names that need more questions."""
        publishers, subscribers, servers = (defaultdict[str, set[str]](set) for _ in range(3))
        for (name, namespace), has in self._has.items():
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
        self._names.hurry(
            topic
            for topic in matched & self._ends.keys()
            if publishers[topic] != self._publishers.get(topic)
            or subscribers[topic] != self._subscribers.get(topic)
        )
        wanted = {*self._named.services, *(f"{name}{SEND}" for name in self._named.actions)}
        unserved = wanted - servers.keys()
        self._names.follow(matched | unpublished | unserved)
        self._ends = {
            topic: ends for topic, ends in self._ends.items() if topic in matched | unpublished
        }
        self._counted &= unserved
        self._publishers, self._subscribers, self._servers = publishers, subscribers, servers

    def _ask_for_names(self, has_time: Callable[[], bool]) -> bool:
        """Ask for the names that are due; True when something is known that was not before."""
        if self._is_partly_asked:  # of most names a node will tell
            return False
        before = dict(self._ends), set(self._counted)
        for name in self._names.due():
            if name in self._named.topics:
                self._ends[name] = self._ask_for_ends(name)
            elif self._node.count_services(name):  # of two nodes of one name ROS tells of one
                self._counted.add(name)
            else:
                self._counted.discard(name)
            if not has_time():
                break
        return before != (self._ends, self._counted)

    def _ask_for_ends(self, topic: str) -> _Ends:
        publishers = self._node.get_publishers_info_by_topic(topic)
        nodes = frozenset(in_namespace(i.node_namespace, i.node_name) for i in publishers)
        subscriptions = self._node.get_subscriptions_info_by_topic(topic) if nodes else ()
        return _Ends(nodes, mismatches(topic, publishers, subscriptions, self._console))

    def _list(self) -> None:
        """Put together what is there."""
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
        ends = self._ends.get(name, _Ends(frozenset(), ()))
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
