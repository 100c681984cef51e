"""Which nodes are there, what they offer, and when they were last heard. ROS thread only."""

from __future__ import annotations

import contextlib

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
)

_SMOOTHING = 0.2  # weight of the newest interval in a rate


class Graph:
    """Looks at the graph when asked to, and keeps when each node last gave a sign of life."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._heard: dict[str, float] = {}
        self._interval: dict[str, float] = {}
        self._last: dict[str, float] = {}
        self._publisher: dict[str, str] = {}
        self.names: list[str] = []
        self.services: dict[str, list[str]] = {}  # types by name, of clients too
        self.offered: frozenset[str] = frozenset()

    def look(self) -> bool:
        """Ask what is on the graph now; True when something came or went."""
        names = sorted({_full(*pair) for pair in self._node.get_node_names_and_namespaces()})
        services = dict(self._node.get_service_names_and_types())
        # a name alone may be that of a client, our own for one: servers are counted
        count = self._node.count_services
        offered = {name for name in (RESET, STOP, RELEASE, CHARGE) if count(name)}
        if count(f"{MOVE}/_action/send_goal"):
            offered.add(MOVE)
        for topic in (BATTERY, MOTOR):
            for info in self._node.get_publishers_info_by_topic(topic)[:1]:
                self._publisher[topic] = _full(info.node_name, info.node_namespace)
                offered.add(topic)
        for name in set(self._last) - set(names):  # its rate starts over when it comes back
            del self._last[name]
            self._interval.pop(name, None)
        changed = names != self.names or offered != self.offered
        self.names, self.services, self.offered = names, services, frozenset(offered)
        return changed

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

    def heard_log(self, logger: str, now: float) -> None:
        """A log line of that logger came at `now` (s)."""
        name = "/" + logger.replace(".", "/")
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


def _full(name: str, namespace: str) -> str:
    return f"{namespace.rstrip('/')}/{name}"
