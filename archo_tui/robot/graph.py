"""The nodes on the graph, what they offer, and when they were last heard. ROS thread only."""

from __future__ import annotations

import contextlib
import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # rclpy has no public name for it
from rclpy.node import Node

from archo_tui.robot.audit_records import TOPIC
from archo_tui.robot.consoles import author
from archo_tui.robot.message_rate import MessageRate
from archo_tui.robot.resources import SEND, Resources, Types
from archo_tui.robot.state import NodeState, Resource, in_namespace
from archo_tui.robot_file.model import RobotFile
from archo_tui.ros_names import package_of

SHARE = 0.05  # of the ROS thread's time that looks at the graph take at most
_SLICE = 0.02  # s of CPU in which a look asks for details; STOP waits for it, and for the rest
_OF_NODES = ("rcl_interfaces", "type_description_interfaces")  # services that every node has


class Graph:
    """Looks at the graph when asked to, and keeps when each node last gave a sign of life."""

    def __init__(self, node: Node, robot: RobotFile) -> None:
        """Take the names of the robot file; `look` asks the graph for them."""
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
        self.has_clock = False  # somebody publishes simulated time
        self.elsewhere: tuple[str, ...] = ()  # other namespaces with nodes
        self.consoles: tuple[str, ...] = ()  # other consoles of this namespace
        self.mute: frozenset[str] = frozenset()  # those that do not publish what they do
        self.servers: dict[str, frozenset[str]] = {}  # the nodes that serve each action
        self.action_types: dict[str, tuple[str, ...]] = {}
        self.rest = 0.0  # s after a look in which the next one would take too much of the thread
        self._seen: object = None  # at the last look, of what a snapshot shows
        self._resources = Resources(node, self.is_ours)
        self._heard: dict[str, float] = {}  # by node, as all below
        self._node_rates: dict[str, MessageRate] = {}
        self._topic_rates: dict[str, MessageRate] = {}
        self._publisher: dict[str, str] = {}
        self.names: list[str] = []
        self.count: dict[str, int] = {}  # how many nodes have each of the names
        self.services: dict[str, list[str]] = {}  # types by name, of clients too
        self.offered: frozenset[str] = frozenset()
        self._named_services: dict[str, tuple[str, ...]] = {}  # types, of clients too
        self._named_actions: dict[str, tuple[str, ...]] = {}

    def look(self) -> bool:
        """Ask what is on the graph now; True when something came or went.

        It is next due when this one has been SHARE of the time until then.
        """
        begun = time.thread_time()
        changed = self._look()
        self.rest = (time.thread_time() - begun) / SHARE
        return changed

    def look_for(self, service: str) -> None:
        """See whether a service of the robot's file has come, and nothing else."""
        if self._node.count_services(service):
            self._look_at_services()
            self.offered |= {service}

    def _look(self) -> bool:
        pairs = self._node.get_node_names_and_namespaces()
        found = Counter(_full(*pair) for pair in pairs)
        names = sorted(name for name in found if self.is_ours(name))
        others = {name.rpartition("/")[0] or "/" for name in found if not is_hidden(name)}
        self.elsewhere = tuple(sorted(others - {self.namespace}))
        own = self._node.get_fully_qualified_name()
        here = [name for name in found if name.rpartition("/")[0] == self._below[:-1]]
        self.consoles = tuple(sorted(filter(None, (author(n) for n in here if n != own))))
        self.mute = frozenset(self.consoles)
        if self.consoles:
            self.mute -= self._publishers_of_acts()
        self.count = {name: found[name] for name in names}
        self.has_clock = self._node.count_publishers("/clock") > 0
        self.twice = tuple(name for name in names if found[name] > 1)
        self._look_at_services()
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
        end = time.thread_time() + _SLICE
        self._resources.look(
            frozenset(pairs),
            self._named_services,
            self._named_actions,
            lambda: time.thread_time() < end,
        )
        rivals = {name: self.rivals(name) for name in self._alone}
        self.several = {name: nodes for name, nodes in rivals.items() if nodes}
        for name in set(self._node_rates) - set(names):  # its rate starts over when it comes back
            del self._node_rates[name]
        there = (
            names,
            offered,
            self.actions,
            self.served,
            self.consoles,
            self.resources,
            self.has_clock,
        )
        seen = there, self.publishers, self.twice, self.elsewhere, self.several
        changed = seen != self._seen
        self._seen = seen
        self.names, self.offered = names, frozenset(offered)
        return changed

    def _publishers_of_acts(self) -> set[str]:
        infos = self._node.get_publishers_info_by_topic(TOPIC)
        return {author(_full(*_of(info))) for info in infos}

    def _look_at_action(self, action: str) -> None:
        infos = self._node.get_publishers_info_by_topic(f"{action}/_action/feedback")
        self.servers[action] = frozenset(_full(*_of(info)) for info in infos)
        self.action_types[action] = _action_types(infos)

    def _look_at_services(self) -> None:
        """Ask for the names of services and actions, without those that every node has."""
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

    def is_ours(self, name: str) -> bool:
        """Return True for a name in the robot's namespace, or below it, that is not hidden."""
        return name.startswith(self._below) and not is_hidden(name)

    def rivals(self, name: str) -> tuple[str, ...]:
        """Return the nodes that serve a service or an action; empty if fewer than two do."""
        found = []
        for service in (name, f"{name}{SEND}"):
            count = self._node.count_services(service)
            if count > 1:
                nodes = [node for node, _ in self._servers(service)]
                # of two nodes of one name ROS tells of one
                found += [*nodes, *[nodes[-1] if nodes else name] * (count - len(nodes))]
        return tuple(found)

    def holders(self, service: str) -> dict[str, frozenset[bytes]]:
        """Return the nodes that serve a service, each with ids that differ after a restart.

        The ids are those of its publishers of /parameter_events, which every node of rclcpp and
        rclpy has; of another node there are none, and only its coming and leaving is seen.
        """
        ids = _ids_by_node(self._node.get_publishers_info_by_topic("/parameter_events"))
        return {node: ids.get(node, frozenset()) for node, _ in self._servers(service)}

    def publisher_ids(self, topic: str) -> frozenset[bytes]:
        """Return the ids of the publishers of a topic: another one after a restart."""
        by_node = _ids_by_node(self._node.get_publishers_info_by_topic(topic))
        return frozenset().union(*by_node.values())

    def served_types(self, name: str) -> list[str]:
        """Return the types of a service's servers, sorted."""
        return sorted({kind for _, kinds in self._servers(name) for kind in kinds})

    def _servers(self, service: str) -> list[tuple[str, list[str]]]:
        """Return the nodes that serve a service, with its types, by asking every node."""
        found, full = [], str(self._node.resolve_service_name(service))
        for node, namespace in sorted(set(self._node.get_node_names_and_namespaces())):
            with contextlib.suppress(NodeNameNonExistentError):  # it has left meanwhile
                served = dict(self._node.get_service_names_and_types_by_node(node, namespace))
                if full in served:
                    found.append((_full(node, namespace), served[full]))
        return found

    def heard_topic(self, topic: str, now: float) -> None:
        """Take note of a message on one of the console's topics at `now`, in monotonic s."""
        _heard(self._topic_rates, topic, now)
        name = self._publisher.get(topic)
        if name is not None:
            _heard(self._node_rates, name, now)
            self._heard[name] = now

    def heard_log(self, name: str, now: float) -> None:
        """Take note of a log line of a node at `now`, in monotonic s."""
        if name in self.names:
            self._heard[name] = now

    def states(self) -> tuple[NodeState, ...]:
        """Every node, by name."""
        return tuple(
            NodeState(
                name,
                self._heard.get(name),
                self._node_rates[name].hertz if name in self._node_rates else None,
            )
            for name in self.names
        )

    @property
    def actions(self) -> Types:
        """The types of every action that is served, by its name."""
        return self._resources.actions

    @property
    def served(self) -> Types:
        """The types of every service that is served, by its name, without those of every node."""
        return self._resources.services

    @property
    def resources(self) -> tuple[Resource, ...]:
        """Topics, services and actions; the same object until something changes."""
        return self._resources.all

    def message_rates(self) -> dict[str, MessageRate]:
        """Return how often each topic that the console hears comes, by its full name."""
        return {
            in_namespace(self.namespace, topic): rate for topic, rate in self._topic_rates.items()
        }


def _heard(rates: dict[str, MessageRate], name: str, now: float) -> None:
    rates[name] = rates[name].with_message_at(now) if name in rates else MessageRate(now)


def is_of_every_node(types: Sequence[str]) -> bool:
    """Return True for a service that each node has: for its parameters, log or types."""
    return package_of(types[0]) in _OF_NODES


def is_hidden(name: str) -> bool:
    """Return True if a part of a name begins with `_`, as of ROS's tools that come and go."""
    return "/_" in name


def _action_types(infos: Any) -> tuple[str, ...]:
    return tuple(sorted({info.topic_type.removesuffix("_FeedbackMessage") for info in infos}))


def _ids_by_node(infos: Any) -> dict[str, frozenset[bytes]]:
    found: dict[str, frozenset[bytes]] = {}
    for info in infos:
        name = _full(*_of(info))
        found[name] = found.get(name, frozenset()) | {bytes(info.endpoint_gid)}
    return found


def _of(info: Any) -> tuple[str, str]:
    return info.node_name, info.node_namespace


def _full(name: str, namespace: str) -> str:
    return in_namespace(namespace, name)
