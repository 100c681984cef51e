"""The graph of a ROS domain, which all its nodes in this process share.

Topics and services are the only primitives. A publisher keeps a tuple of the subscriptions that
match it, rebuilt when an endpoint of its topic comes or goes: publishing touches nobody else.
"""

from __future__ import annotations

import threading
from collections import defaultdict
from typing import TYPE_CHECKING, Any

from rclpy.qos import incompatible_policy

if TYPE_CHECKING:
    from rclpy.client import Client
    from rclpy.node import Node
    from rclpy.publisher import Publisher
    from rclpy.service import Service
    from rclpy.subscription import Subscription


class Topic:
    """The publishers and subscriptions of one topic name, in the order in which they came."""

    def __init__(self) -> None:
        self.publishers: list[Publisher[Any]] = []
        self.subscriptions: list[Subscription[Any]] = []


class Graph:
    """The nodes of one domain, and its topics, services and clients by their names on the graph.

    `lock` guards every list; messages are delivered without it. `changed` is notified whenever a
    node, publisher, subscription, service or client comes or goes.
    """

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.changed = threading.Condition(self.lock)
        self.nodes: list[Node] = []
        self.topics: dict[str, Topic] = defaultdict(Topic)
        self.services: dict[str, list[Service[Any, Any]]] = defaultdict(list)
        self.clients: dict[str, list[Client[Any, Any]]] = defaultdict(list)

    def add_publisher(self, publisher: Publisher[Any]) -> None:
        """Put a publisher on the graph, and connect it with the subscriptions that match.

        Handlers on both sides count each endpoint of the same type with incompatible QoS.
        """
        with self.changed:
            topic = self.topics[publisher._topic_name]
            topic.publishers.append(publisher)
            self._match(publisher, topic.subscriptions)
            self.changed.notify_all()

    def add_subscription(self, subscription: Subscription[Any]) -> None:
        """Put a subscription on the graph, and connect it with the publishers that match.

        Matching publishers hand over at once what they keep for late joiners. Handlers on both
        sides count each endpoint of the same type with incompatible QoS.
        """
        with self.changed:
            topic = self.topics[subscription._topic_name]
            topic.subscriptions.append(subscription)
            for publisher in topic.publishers:
                self._match(publisher, [subscription])
                if subscription in publisher._matched:
                    publisher._replay(subscription)
            self.changed.notify_all()

    def remove_publisher(self, publisher: Publisher[Any]) -> None:
        """Take a publisher off the graph, if it is there, and disconnect it."""
        with self.changed:
            publisher._matched = ()
            self._remove(publisher, self.topics[publisher._topic_name].publishers)

    def remove_subscription(self, subscription: Subscription[Any]) -> None:
        """Take a subscription off the graph, if it is there; no publisher delivers to it then."""
        with self.changed:
            topic = self.topics[subscription._topic_name]
            for publisher in topic.publishers:
                publisher._matched = tuple(s for s in publisher._matched if s is not subscription)
            self._remove(subscription, topic.subscriptions)

    def _remove(self, endpoint: Any, endpoints: list[Any]) -> None:
        """Take an endpoint out of its list, and forget a topic without any."""
        if endpoint in endpoints:
            endpoints.remove(endpoint)
        topic = self.topics[endpoint._topic_name]
        if not topic.publishers and not topic.subscriptions:
            del self.topics[endpoint._topic_name]
        self.changed.notify_all()

    def add_named(self, table: dict[str, list[Any]], name: str, item: Any) -> None:
        """Put a service or client into its table, and wake those who wait for the graph."""
        with self.changed:
            table[name].append(item)
            self.changed.notify_all()

    def remove_named(self, table: dict[str, list[Any]], name: str, item: Any) -> None:
        """Take a service or client out of its table, if it is there.

        Those who wait for the graph are woken. The arguments are those of `add_named`.
        """
        with self.changed:
            if item in table.get(name, ()):
                table[name].remove(item)
                if not table[name]:
                    del table[name]
            self.changed.notify_all()

    def servers(self, name: str, srv_type: type) -> list[Service[Any, Any]]:
        """Return the services of that name and type, in the order in which they came."""
        with self.lock:
            return [s for s in self.services.get(name, ()) if s.srv_type is srv_type]

    def _match(self, publisher: Publisher[Any], subscriptions: list[Subscription[Any]]) -> None:
        matched = list(publisher._matched)
        for subscription in subscriptions:
            if subscription.msg_type is not publisher.msg_type:
                continue  # As in DDS, endpoints of other types do not see each other.
            policy = incompatible_policy(publisher.qos_profile, subscription.qos_profile)
            if policy is None:
                matched.append(subscription)
            else:
                for handler in (*publisher.event_handlers, *subscription.event_handlers):
                    handler._count(policy)
        publisher._matched = tuple(matched)


_graphs: dict[int, Graph] = {}
_graphs_lock = threading.Lock()


def graph_of(domain_id: int) -> Graph:
    """Return the graph of a domain, made at the first call; all contexts of the domain share it."""
    with _graphs_lock:
        return _graphs.setdefault(domain_id, Graph())
