"""The half of `rclpy.node.Node` that asks what is on the graph."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from rclpy._rclpy_pybind11 import NodeNameNonExistentError
from rclpy.qos import QoSProfile

if TYPE_CHECKING:
    from rclpy._graph import Graph
    from rclpy.node import Node

NamesAndTypes = list[tuple[str, list[str]]]


class TopicEndpointInfo(NamedTuple):
    """One publisher or subscription of a topic."""

    node_name: str
    node_namespace: str
    topic_type: str
    qos_profile: QoSProfile


class NodeGraph:
    """Names, types and counts of what every node of the domain offers and uses."""

    _graph: Graph

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        raise NotImplementedError

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        raise NotImplementedError

    def get_node_names(self) -> list[str]:
        """Names without namespaces."""
        return [name for name, _ in self.get_node_names_and_namespaces()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """`(name, namespace)` of every node."""
        with self._graph.lock:
            return [(node.get_name(), node.get_namespace()) for node in self._graph.nodes]

    def get_fully_qualified_node_names(self) -> list[str]:
        """`/namespace/name` of every node."""
        with self._graph.lock:
            return [node.get_fully_qualified_name() for node in self._graph.nodes]

    def get_topic_names_and_types(self, no_demangle: bool = False) -> NamesAndTypes:
        """Every topic that has a publisher or a subscription."""
        with self._graph.lock:
            return _sorted(
                (name, endpoint.msg_type)
                for name, topic in self._graph.topics.items()
                for endpoint in (*topic.publishers, *topic.subscriptions)
            )

    def get_service_names_and_types(self) -> NamesAndTypes:
        """Every service that somebody offers, or has a client of: `count_services` tells which."""
        with self._graph.lock:
            return _sorted(
                (name, endpoint.srv_type)
                for table in (self._graph.services, self._graph.clients)
                for name, endpoints in table.items()
                for endpoint in endpoints
            )

    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """What one node publishes. Raises NodeNameNonExistentError."""
        publishers = [p for node in self._named(node_name, node_namespace) for p in node.publishers]
        return _sorted((p.topic_name, p.msg_type) for p in publishers)

    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """What one node subscribes. Raises NodeNameNonExistentError."""
        nodes = self._named(node_name, node_namespace)
        return _sorted((s.topic_name, s.msg_type) for node in nodes for s in node.subscriptions)

    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """What services one node offers. Raises NodeNameNonExistentError."""
        nodes = self._named(node_name, node_namespace)
        return _sorted((s.service_name, s.srv_type) for node in nodes for s in node.services)

    def get_publishers_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Who publishes a topic, with which type and QoS."""
        name = self.resolve_topic_name(topic_name)
        with self._graph.lock:
            topic = self._graph.topics.get(name)
            return [_info(endpoint) for endpoint in topic.publishers] if topic else []

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Who subscribes a topic, with which type and QoS."""
        name = self.resolve_topic_name(topic_name)
        with self._graph.lock:
            topic = self._graph.topics.get(name)
            return [_info(endpoint) for endpoint in topic.subscriptions] if topic else []

    def count_publishers(self, topic_name: str) -> int:
        """How many publish a topic."""
        return len(self.get_publishers_info_by_topic(topic_name))

    def count_subscribers(self, topic_name: str) -> int:
        """How many subscribe a topic."""
        return len(self.get_subscriptions_info_by_topic(topic_name))

    def count_services(self, service_name: str) -> int:
        """How many offer a service."""
        name = self.resolve_service_name(service_name)
        with self._graph.lock:
            return len(self._graph.services.get(name, ()))

    def count_clients(self, service_name: str) -> int:
        """How many have a client of a service."""
        name = self.resolve_service_name(service_name)
        with self._graph.lock:
            return len(self._graph.clients.get(name, ()))

    def _named(self, name: str, namespace: str) -> list[Node]:
        with self._graph.lock:
            nodes = [
                node
                for node in self._graph.nodes
                if node.get_name() == name and node.get_namespace() == namespace
            ]
        if not nodes:
            raise NodeNameNonExistentError(
                f"cannot get names and types for nonexistent node: {name} in {namespace}"
            )
        return nodes


def _sorted(pairs: Iterable[tuple[str, Any]]) -> NamesAndTypes:
    types: dict[str, set[str]] = {}
    for name, kind in pairs:
        types.setdefault(name, set()).add(kind.__type_name__)
    return [(name, sorted(types[name])) for name in sorted(types)]


def _info(endpoint: Any) -> TopicEndpointInfo:
    node = endpoint._node
    return TopicEndpointInfo(
        node.get_name(),
        node.get_namespace(),
        endpoint.msg_type.__type_name__,
        endpoint.qos_profile,
    )
