"""A graph of thousands of names: little is asked at a look, and all of it is found in time."""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy._rclpy_pybind11 import NodeNameNonExistentError
from rclpy.qos import QoSProfile

from archo_tui.robot.graph.graph import PERIOD, Resources
from archo_tui.robot.state.graph import Resource

pytestmark = pytest.mark.pure

INT, TRIGGER = "std_msgs/msg/Int32", "std_srvs/srv/Trigger"
Names = dict[str, list[str]]  # what a node has, by node


class Graph:
    """The questions of a node to a graph, answered from three tables and counted."""

    def __init__(self, nodes: int) -> None:
        self.nodes = [f"n{number}" for number in range(nodes)]
        self.publishes: Names = {node: [f"/{node}/t{k}" for k in range(20)] for node in self.nodes}
        self.subscribes: Names = {node: [] for node in self.nodes}
        self.serves: Names = {node: [f"/{node}/s"] for node in self.nodes}
        self.nameless: set[str] = set()  # topics and services of no node that ROS knows
        self.asked: Counter[str] = Counter()

    def get_fully_qualified_name(self) -> str:
        return "/_console"

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        had = self.publishes, self.subscribes
        topics = {topic for names in had for node in self.nodes for topic in names[node]}
        return [(topic, [INT]) for topic in sorted(topics | self.nameless - {"/bare_service"})]

    def _of(self, names: Names, kind: str, node: str) -> list[tuple[str, list[str]]]:
        self.asked["node"] += 1
        if node not in self.nodes:
            raise NodeNameNonExistentError
        return [(name, [kind]) for name in names[node]]

    def get_publisher_names_and_types_by_node(self, node: str, _: str) -> Any:
        return self._of(self.publishes, INT, node)

    def get_subscriber_names_and_types_by_node(self, node: str, _: str) -> Any:
        return self._of(self.subscribes, INT, node)

    def get_service_names_and_types_by_node(self, node: str, _: str) -> Any:
        return self._of(self.serves, TRIGGER, node)

    def _ends(self, names: Names, topic: str) -> list[Any]:
        self.asked["name"] += 1
        own = [node for node in self.nodes if topic in names[node]]
        unknown = ["_NODE_NAME_UNKNOWN_"] if topic in self.nameless else []
        return [
            SimpleNamespace(
                node_name=node, node_namespace="/", topic_type=INT, qos_profile=QoSProfile(depth=1)
            )
            for node in own + unknown
        ]

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        return self._ends(self.publishes, topic)

    def get_subscriptions_info_by_topic(self, topic: str) -> list[Any]:
        return self._ends(self.subscribes, topic)

    def count_services(self, name: str) -> int:
        self.asked["name"] += 1
        return int(name in self.nameless)


class Looks:
    """Resources on such a graph."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.resources = Resources(graph, lambda _: True)  # type: ignore[arg-type]

    def look(self, pieces: int = 100_000) -> None:
        """Look once, with time for so many questions to nodes or for names."""
        left = iter(range(pieces - 1))
        graph = self.graph
        served = {name for node in graph.nodes for name in graph.serves[node]}
        self.resources.poll(
            frozenset((node, "/") for node in graph.nodes),
            {name: (TRIGGER,) for name in served | (graph.nameless - {"/bare"})},
            {},
            lambda: next(left, None) is not None,
        )

    def row(self, name: str) -> Resource | None:
        """Return what is listed under a name; None when nothing is."""
        return next((row for row in self.resources.all if row.name == name), None)

    def mismatches(self, name: str) -> tuple[str, ...]:
        """Return what does not fit there."""
        row = self.row(name)
        return () if row is None else row.mismatches

    def nodes(self, name: str) -> tuple[str, ...]:
        """Return the nodes that have it."""
        row = self.row(name)
        return () if row is None else row.nodes


def test_at_rest_a_thirtieth_of_the_nodes_is_asked() -> None:
    graph = Graph(600)
    looks = Looks(graph)
    looks.look()
    assert len(looks.resources.all) == 600 * 21
    graph.asked.clear()
    for _ in range(PERIOD):
        looks.look()
    assert graph.asked == {"node": 3 * 600}  # three questions each


def test_a_look_keeps_to_its_time_and_the_next_goes_on() -> None:
    graph = Graph(200)
    looks = Looks(graph)
    for number in range(1, 21):
        looks.look(pieces=10)
        assert graph.asked["node"] <= 3 * 10 * number
    assert looks.nodes("/n199/t0") == ("/n199",)
    assert all(looks.nodes(f"/n{number}/s") == (f"/n{number}",) for number in range(200))


def test_a_publisher_that_leaves_a_shared_topic_is_seen_in_half_a_minute() -> None:
    graph = Graph(200)
    graph.publishes["n0"].append("/n1/t0")
    looks = Looks(graph)
    looks.look()
    assert looks.nodes("/n1/t0") == ("/n0", "/n1")
    graph.publishes["n1"].remove("/n1/t0")
    for _ in range(PERIOD):
        looks.look()
    assert looks.nodes("/n1/t0") == ("/n0",)


def test_a_new_name_is_seen_with_its_node_at_the_next_look() -> None:
    graph = Graph(200)
    looks = Looks(graph)
    looks.look()
    graph.publishes["n77"].append("/new")
    graph.serves["n78"].append("/do")
    looks.look()
    assert looks.nodes("/new") == ("/n77",)
    assert looks.nodes("/do") == ("/n78",)


def test_what_a_node_that_left_had_is_nobodys() -> None:
    graph = Graph(200)
    graph.subscribes["n0"].append("/n1/t0")
    looks = Looks(graph)
    looks.look()
    graph.nodes.remove("n1")
    looks.look()
    assert looks.nodes("/n1/t0") == ()
    assert looks.row("/n1/s") is None


def test_a_node_not_known_yet_is_asked_again() -> None:
    graph = Graph(20)
    looks = Looks(graph)
    looks.look()
    graph.nameless = {"/bare"}
    known, graph.nodes = graph.nodes, [*graph.nodes, "late"]
    late = graph.nodes.pop()
    graph.serves[late], graph.publishes[late], graph.subscribes[late] = ["/late"], [], []
    pairs = frozenset((node, "/") for node in [*known, late])
    looks.resources.poll(pairs, {"/late": (TRIGGER,)}, {}, lambda: True)
    assert looks.row("/late") is None
    assert looks.nodes("/bare") == ("/_NODE_NAME_UNKNOWN_",)
    graph.nodes.append(late)
    looks.resources.poll(pairs, {"/late": (TRIGGER,)}, {}, lambda: True)
    assert looks.nodes("/late") == ("/late",)


def test_what_no_node_is_known_for_is_there_all_the_same() -> None:
    graph = Graph(200)
    graph.nameless = {"/bare", "/bare_service"}
    looks = Looks(graph)
    looks.look()
    assert looks.nodes("/bare") == ("/_NODE_NAME_UNKNOWN_",)
    row = looks.row("/bare_service")
    assert row is not None
    assert row.nodes == ()


def graph_of_other_types() -> tuple[Graph, list[bool]]:
    """Return a graph whose subscriptions have another type once the list is not empty."""
    graph, are_others = Graph(100), list[bool]()
    infos = graph.get_subscriptions_info_by_topic

    def find(topic: str) -> list[Any]:
        found = infos(topic)
        for info in found if are_others else ():
            info.topic_type = "std_msgs/msg/Bool"
        return found

    graph.get_subscriptions_info_by_topic = find  # type: ignore[method-assign]
    for node in graph.nodes:
        graph.subscribes[node].append(f"/{node}/t0")
    return graph, are_others


def test_ends_that_do_not_fit_any_more_are_seen_in_half_a_minute() -> None:
    graph, are_others = graph_of_other_types()
    looks = Looks(graph)
    looks.look()
    assert not any(row.mismatches for row in looks.resources.all)
    are_others.append(True)
    for _ in range(PERIOD):
        looks.look()
    assert looks.mismatches("/n50/t0") == (
        "n50 hears nothing of n50 on /n50/t0: it subscribes to std_msgs/msg/Bool,"
        " published is std_msgs/msg/Int32. Use one type in both.",
    )


def test_a_new_subscription_has_its_topic_checked_at_once() -> None:
    graph, are_others = graph_of_other_types()
    looks = Looks(graph)
    for _ in range(2):
        looks.look()
    are_others.append(True)
    graph.subscribes["n99"] += ["/n50/t0", "/new"]  # a new name has all nodes asked
    looks.look()
    assert len(looks.mismatches("/n50/t0")) == 2
