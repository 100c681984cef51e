"""The nodes on the graph, what they offer, and how often their messages come. ROS thread only."""

from __future__ import annotations

import contextlib
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from typing import Any

from rclpy._rclpy_pybind11 import NodeNameNonExistentError  # It has no public name.
from rclpy.node import Node

from archo_tui.robot.clients import author
from archo_tui.robot.graph.resources import SEND, Resources
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.state.audit_records import TOPIC
from archo_tui.robot.state.graph import NodeState, in_namespace, node_states
from archo_tui.robot_file.model import RobotFile
from archo_tui.ros_names import package_of

SHARE = 0.05  # The share of the ROS thread's time that polls take at most.
_SLICE = 0.02  # Seconds of CPU time in a poll for details; a STOP waits until the poll is over.
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
        self.names: list[str] = []  # The nodes in the namespace, or below it, that are not hidden.
        self.node_counts: dict[str, int] = {}  # The number of nodes that have each of these names.
        self.duplicate_nodes: tuple[str, ...] = ()  # The names that several nodes have.
        # The types of each service in all namespaces, also of one that has only clients.
        self.services: dict[str, list[str]] = {}
        # The names of the robot file for which a node publishes or serves something.
        self.offered: frozenset[str] = frozenset()
        # The nodes of each topic of the robot file that several nodes publish.
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
        self._last: object = None  # What the last poll found, as far as a snapshot shows it.
        self.listed = Resources(node, self.is_ours)  # What the robot offers.
        # The robot's services and actions with their types, also those that have only clients.
        self._named_services: dict[str, tuple[str, ...]] = {}
        self._named_actions: dict[str, tuple[str, ...]] = {}
        self._logged: dict[str, float] = {}  # By node, in monotonic seconds.
        self._topic_rates: dict[str, MessageRate] = {}
        self._publisher: dict[str, str] = {}  # The first publisher of each topic of the file.

    def poll(self) -> bool:
        """Read the graph into the attributes; return True if what a snapshot shows has changed.

        The QoS and the nodes of topics, services and actions are read a part at a time: on a large
        graph they are complete only after several polls.
        """
        begun, before = time.thread_time(), self._last
        self._poll()
        self.rest = (time.thread_time() - begun) / SHARE
        return self._last != before

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
        names = sorted(name for name in found if self.is_ours(name))
        others = {name.rpartition("/")[0] or "/" for name in found if not is_hidden(name)}
        self.other_namespaces = tuple(sorted(others - {self.namespace}))
        self._find_consoles(found)
        self.silent_consoles = frozenset(self.consoles)
        if self.consoles:
            self.silent_consoles -= self._record_publishers()
        self.node_counts = {name: found[name] for name in names}
        self.has_clock = self._node.count_publishers("/clock") > 0
        self.duplicate_nodes = tuple(name for name in names if found[name] > 1)
        self._read_services()
        # A name may be that of a client, as of our own, so the servers are counted.
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
        self.names, self.offered = names, frozenset(offered)
        listed = self.listed
        self._last = (
            *(names, offered, listed.actions, listed.services, listed.all, self.consoles),
            *(self.has_clock, self.publishers, self.duplicate_nodes, self.other_namespaces),
            self.duplicates,
        )

    def _record_publishers(self) -> set[str]:
        infos = self._node.get_publishers_info_by_topic(TOPIC)
        return {author(_full(*_of(info))) for info in infos}

    def _read_action(self, action: str) -> None:
        infos = self._node.get_publishers_info_by_topic(f"{action}/_action/feedback")
        self.servers[action] = frozenset(_full(*_of(info)) for info in infos)
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
            ids[_full(*_of(info))].add(bytes(info.endpoint_gid))
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
        """Record that a node was heard by a log line; a name that is not in `names` is ignored."""
        if name in self.names:
            self._logged[name] = now

    def node_states(self) -> tuple[NodeState, ...]:
        """Return for every node when it was last heard, and its rate, sorted by name."""
        rates = self._topic_rates.items()
        by_node = ((self._publisher.get(topic, ""), rate) for topic, rate in rates)
        return tuple(node_states(self.names, self._logged, by_node).values())

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


def _of(info: Any) -> tuple[str, str]:
    return info.node_name, info.node_namespace


def _full(name: str, namespace: str) -> str:
    return in_namespace(namespace, name)
