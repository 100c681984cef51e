"""What is published and served, and by whom. ROS thread only."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping

from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # rclpy has no public name for it
from rclpy.node import Node

from archo_tui.robot.endpoints import mismatches
from archo_tui.robot.state import ACTION, SERVICE, TOPIC, Resource, in_namespace

_OF_EVERY_NODE = ("/rosout", "/parameter_events")
SEND, _FEEDBACK = "/_action/send_goal", "/_action/feedback"

Pairs = frozenset[tuple[str, str]]  # (name, namespace) of nodes
Types = Mapping[str, tuple[str, ...]]  # by name


class Resources:
    """Counts each second; asks who it is only when something came or went."""

    def __init__(self, node: Node, is_ours: Callable[[str], bool]) -> None:
        """`is_ours(name)` tells what belongs to the robot."""
        self._node, self._is_ours = node, is_ours
        self._counted: object = None  # at the last look
        self._serving: Mapping[str, int] = {}  # how many serve each service, at the last look
        self._served: dict[tuple[str, str], frozenset[str]] = {}  # services, by node
        self.all: tuple[Resource, ...] = ()
        self.services: Types = {}  # that somebody serves
        self.actions: Types = {}

    def look(self, nodes: Pairs, services: Types, actions: Types) -> None:
        """Look again; `services` and `actions` may have a client only."""
        node = self._node
        topics = {
            name: (tuple(types), node.count_publishers(name), node.count_subscribers(name))
            for name, types in node.get_topic_names_and_types()
            if self._is_ours(name) and name not in _OF_EVERY_NODE
        }
        serving = {name: node.count_services(name) for name in services}
        acting = {
            name: (node.count_services(name + SEND), node.count_publishers(name + _FEEDBACK))
            for name in actions
        }
        counted = nodes, topics, services, serving, actions, acting
        if counted == self._counted:
            return
        self.services = {name: types for name, types in services.items() if serving[name]}
        self.actions = {name: types for name, types in actions.items() if acting[name][0]}
        answered = self._ask(nodes, serving)
        self._counted = counted if answered else None
        of_topics = {name: types for name, (types, _, _) in topics.items()}
        self.all = (
            *(self._topic(name, of_topics[name]) for name in sorted(of_topics)),
            *_resources(SERVICE, self.services, self._servers),
            *_resources(ACTION, self.actions, lambda name: self._publishers(name + _FEEDBACK)),
        )

    def _ask(self, nodes: Pairs, serving: Mapping[str, int]) -> bool:
        """Ask each node what it serves, as rclpy does not tell it by service.

        Only the new ones, while as many serve each service as before. False: ask again.
        """
        if serving != self._serving:
            self._serving, self._served = serving, {}
        self._served = {pair: names for pair, names in self._served.items() if pair in nodes}
        for name, namespace in nodes - self._served.keys() if self.services else ():
            with contextlib.suppress(NodeNameNonExistentError):  # it has just left, or just come
                served = self._node.get_service_names_and_types_by_node(name, namespace)
                self._served[name, namespace] = frozenset(service for service, _ in served)
        return not self.services or self._served.keys() == nodes

    def _topic(self, name: str, types: tuple[str, ...]) -> Resource:
        publishers = self._node.get_publishers_info_by_topic(name)
        nodes = {in_namespace(info.node_namespace, info.node_name) for info in publishers}
        subscriptions = self._node.get_subscriptions_info_by_topic(name) if publishers else ()
        unheard = mismatches(name, publishers, subscriptions)
        return Resource(TOPIC, name, types, tuple(sorted(nodes)), unheard)

    def _servers(self, service: str) -> Iterator[str]:
        for (name, namespace), served in self._served.items():
            if service in served:
                yield in_namespace(namespace, name)

    def _publishers(self, topic: str) -> Iterator[str]:
        for info in self._node.get_publishers_info_by_topic(topic):
            yield in_namespace(info.node_namespace, info.node_name)


def _resources(
    kind: str, found: Types, nodes: Callable[[str], Iterable[str]]
) -> Iterator[Resource]:
    for name in sorted(found):
        yield Resource(kind, name, found[name], tuple(sorted(set(nodes(name)))))
