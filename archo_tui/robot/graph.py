"""Which nodes are there, what they offer, and when they were last heard. ROS thread only."""

from __future__ import annotations

import contextlib
from collections import Counter
from typing import Any

from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # rclpy has no public name for it
from rclpy.node import Node

from archo_tui.robot.consoles import author
from archo_tui.robot.state import NodeState, in_namespace
from archo_tui.robots.model import Robot

_SEND = "/_action/send_goal"
_OF_NODES = ("rcl_interfaces", "type_description_interfaces")  # services that every node has
_SMOOTHING = 0.2  # weight of the newest interval in a rate


class Graph:
    """Looks at the graph when asked to, and keeps when each node last gave a sign of life."""

    def __init__(self, node: Node, robot: Robot) -> None:
        """Looks for the names of the robot's file."""
        self._node = node
        self._topics = robot.topics
        self._services = robot.services
        self._actions = tuple(dict.fromkeys(kind.action for kind in robot.goals))
        stop = () if robot.stop is None else (robot.stop.service,)
        self._alone = (*stop, *self._actions)
        self.namespace = node.get_namespace()
        self._below = in_namespace(self.namespace, "")
        self.publishers: dict[str, tuple[str, ...]] = {}  # nodes, by topic, where there are several
        self.twice: tuple[str, ...] = ()  # names that several nodes have
        # the nodes of STOP's service and of the robot's actions, where one request reaches several
        self.several: dict[str, tuple[str, ...]] = {}
        self.elsewhere: tuple[str, ...] = ()  # other namespaces with nodes
        self.consoles: tuple[str, ...] = ()  # other consoles of this namespace
        self.servers: dict[str, frozenset[str]] = {}  # the nodes that serve each action
        self.action_types: dict[str, tuple[str, ...]] = {}
        self._seen: object = None  # at the last look, of what a snapshot shows
        self._heard: dict[str, float] = {}
        self._interval: dict[str, float] = {}
        self._last: dict[str, float] = {}
        self._publisher: dict[str, str] = {}
        self.names: list[str] = []
        self.count: dict[str, int] = {}  # how many nodes have each of the names
        self.services: dict[str, list[str]] = {}  # types by name, of clients too
        self.offered: frozenset[str] = frozenset()
        self.actions: dict[str, tuple[str, ...]] = {}  # types, of every action that is served
        self.served: dict[str, tuple[str, ...]] = {}  # types, of every service but ROS's own

    def look(self) -> bool:
        """Ask what is on the graph now; True when something came or went."""
        found = Counter(_full(*pair) for pair in self._node.get_node_names_and_namespaces())
        names = sorted(name for name in found if self.is_ours(name))
        others = {name.rpartition("/")[0] or "/" for name in found if not _is_hidden(name)}
        self.elsewhere = tuple(sorted(others - {self.namespace}))
        own = self._node.get_fully_qualified_name()
        here = [name for name in found if name.rpartition("/")[0] == self._below[:-1]]
        self.consoles = tuple(sorted(filter(None, (author(n) for n in here if n != own))))
        self.count = {name: found[name] for name in names}
        self.twice = tuple(name for name in names if found[name] > 1)
        services = dict(self._node.get_service_names_and_types())
        # a name alone may be that of a client, our own for one: servers are counted
        count = self._node.count_services
        offered = {name for name in self._services if count(name)}
        self.publishers = {}
        for topic in self._topics:
            nodes = [_full(*_of(i)) for i in self._node.get_publishers_info_by_topic(topic)]
            if nodes:
                self._publisher[topic] = nodes[0]
                offered.add(topic)
            if len(nodes) > 1:
                self.publishers[topic] = tuple(sorted(nodes))
        for action in self._actions:
            if count(f"{action}/_action/send_goal"):
                offered.add(action)
            self._look_at_action(action)
        if services != self.services:
            self._look_at_services(services)
        rivals = {name: self.rivals(name) for name in self._alone}
        self.several = {name: nodes for name, nodes in rivals.items() if nodes}
        for name in set(self._last) - set(names):  # its rate starts over when it comes back
            del self._last[name]
            self._interval.pop(name, None)
        there = names, offered, self.actions, self.served, self.consoles
        seen = there, self.publishers, self.twice, self.elsewhere, self.several
        changed = seen != self._seen
        self._seen = seen
        self.names, self.services, self.offered = names, services, frozenset(offered)
        return changed

    def _look_at_action(self, action: str) -> None:
        infos = self._node.get_publishers_info_by_topic(f"{action}/_action/feedback")
        self.servers[action] = frozenset(_full(*_of(info)) for info in infos)
        self.action_types[action] = _action_types(infos)

    def _look_at_services(self, services: dict[str, list[str]]) -> None:
        """Which services and actions of any kind are served; those of every node are left out."""
        count, self.actions, self.served = self._node.count_services, {}, {}
        for name, kinds in services.items():
            if not name.startswith(self._below) or _is_hidden(name.removesuffix(_SEND)):
                continue
            action = name.removesuffix(_SEND)
            if action != name and count(name):
                types = sorted(kind.removesuffix("_SendGoal") for kind in kinds)
                self.actions[action] = tuple(types)
            elif action == name and kinds[0].partition("/")[0] not in _OF_NODES and count(name):
                self.served[name] = tuple(kinds)

    def is_ours(self, name: str) -> bool:
        """True for a node of the robot's namespace, or below it, that is not hidden."""
        return name.startswith(self._below) and not _is_hidden(name)

    def rivals(self, name: str) -> tuple[str, ...]:
        """The nodes that serve a service or an action, where there are several of them."""
        found = []
        for service in (name, f"{name}{_SEND}"):
            count = self._node.count_services(service)
            if count > 1:
                nodes = [node for node, _ in self._servers(service)]
                # of two nodes of one name ROS tells of one
                found += [*nodes, *[nodes[-1] if nodes else name] * (count - len(nodes))]
        return tuple(found)

    def served_types(self, name: str) -> list[str]:
        """The types of a service's servers."""
        return sorted({kind for _, kinds in self._servers(name) for kind in kinds})

    def _servers(self, service: str) -> list[tuple[str, list[str]]]:
        """The nodes that serve it, and as which types, by asking every node for what it serves."""
        found, full = [], str(self._node.resolve_service_name(service))
        for node, namespace in sorted(set(self._node.get_node_names_and_namespaces())):
            with contextlib.suppress(NodeNameNonExistentError):  # it has left meanwhile
                served = dict(self._node.get_service_names_and_types_by_node(node, namespace))
                if full in served:
                    found.append((_full(node, namespace), served[full]))
        return found

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


def _action_types(infos: Any) -> tuple[str, ...]:
    return tuple(sorted({info.topic_type.removesuffix("_FeedbackMessage") for info in infos}))


def _of(info: Any) -> tuple[str, str]:
    return info.node_name, info.node_namespace


def _full(name: str, namespace: str) -> str:
    return in_namespace(namespace, name)
