"""Which nodes are there, what they offer, and when they were last heard. ROS thread only."""

from __future__ import annotations

import contextlib
from collections import Counter
from typing import Any

from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # rclpy has no public name for it
from rclpy.node import Node

from archo_tui.robot.state import (
    BATTERY,
    CHARGE,
    MOTOR,
    MOVE,
    RELEASE,
    RESET,
    STOP,
    NodeState,
    in_namespace,
)

_SMOOTHING = 0.2  # weight of the newest interval in a rate


class Graph:
    """Looks at the graph when asked to, and keeps when each node last gave a sign of life."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self.namespace = node.get_namespace()
        self._below = in_namespace(self.namespace, "")
        self.publishers: dict[str, tuple[str, ...]] = {}  # nodes, by topic, where there are several
        self.twice: tuple[str, ...] = ()  # names that several nodes have
        self.elsewhere: tuple[str, ...] = ()  # other namespaces with nodes
        self.movers: frozenset[str] = frozenset()  # the nodes that serve the action
        self.move_types: frozenset[str] = frozenset()
        self._seen: object = None  # at the last look, of what a snapshot shows
        self._heard: dict[str, float] = {}
        self._interval: dict[str, float] = {}
        self._last: dict[str, float] = {}
        self._publisher: dict[str, str] = {}
        self.names: list[str] = []
        self.services: dict[str, list[str]] = {}  # types by name, of clients too
        self.offered: frozenset[str] = frozenset()

    def look(self) -> bool:
        """Ask what is on the graph now; True when something came or went."""
        found = Counter(_full(*pair) for pair in self._node.get_node_names_and_namespaces())
        names = sorted(name for name in found if self.is_ours(name))
        others = {name.rpartition("/")[0] or "/" for name in found if not _is_hidden(name)}
        self.elsewhere = tuple(sorted(others - {self.namespace}))
        self.twice = tuple(name for name in names if found[name] > 1)
        services = dict(self._node.get_service_names_and_types())
        # a name alone may be that of a client, our own for one: servers are counted
        count = self._node.count_services
        offered = {name for name in (RESET, STOP, RELEASE, CHARGE) if count(name)}
        if count(f"{MOVE}/_action/send_goal"):
            offered.add(MOVE)
        self.publishers = {}
        for topic in (BATTERY, MOTOR):
            nodes = [_full(*_of(i)) for i in self._node.get_publishers_info_by_topic(topic)]
            if nodes:
                self._publisher[topic] = nodes[0]
                offered.add(topic)
            if len(nodes) > 1:
                self.publishers[topic] = tuple(sorted(nodes))
        movers = self._node.get_publishers_info_by_topic(f"{MOVE}/_action/feedback")
        self.movers = frozenset(_full(*_of(info)) for info in movers)
        self.move_types = frozenset(
            info.topic_type.removesuffix("_FeedbackMessage") for info in movers
        )
        for name in set(self._last) - set(names):  # its rate starts over when it comes back
            del self._last[name]
            self._interval.pop(name, None)
        seen = names, offered, self.publishers, self.twice, self.elsewhere
        changed = seen != self._seen
        self._seen = seen
        self.names, self.services, self.offered = names, services, frozenset(offered)
        return changed

    def is_ours(self, name: str) -> bool:
        """True for a node of the robot's namespace, or below it, that is not hidden."""
        return name.startswith(self._below) and not _is_hidden(name)

    def served_types(self, name: str) -> list[str]:
        """The types of a service's servers, by asking every node for what it serves."""
        found: set[str] = set()
        for node, namespace in self._node.get_node_names_and_namespaces():
            with contextlib.suppress(NodeNameNonExistentError):  # it has left meanwhile
                served = self._node.get_service_names_and_types_by_node(node, namespace)
                found.update(dict(served).get(name, ()))
        return sorted(found)

    def heard_topic(self, topic: str, now: float) -> None:
        """A message came on one of the console's topics at `now` (s)."""
        name = self._publisher.get(topic)
        if name is None:
            return
        last = self._last.get(name)
        if last is not None and now > last:
            before = self._interval.get(name, now - last)
            self._interval[name] = before + _SMOOTHING * (now - last - before)
        self._last[name] = now
        self._heard[name] = now

    def heard_log(self, name: str, now: float) -> None:
        """A log line of that node came at `now` (s)."""
        if name in self.names:
            self._heard[name] = now

    def states(self) -> tuple[NodeState, ...]:
        """Every node, by name."""
        return tuple(
            NodeState(
                name,
                self._heard.get(name),
                1 / self._interval[name] if self._interval.get(name) else None,
            )
            for name in self.names
        )


def logger_node(logger: str) -> str:
    """The node, fully qualified, that has a logger of that name."""
    return "/" + logger.replace(".", "/")


def _is_hidden(name: str) -> bool:
    """True when a part of it begins with `_`: tools of ROS that come and go."""
    return "/_" in name


def _of(info: Any) -> tuple[str, str]:
    return info.node_name, info.node_namespace


def _full(name: str, namespace: str) -> str:
    return in_namespace(namespace, name)
