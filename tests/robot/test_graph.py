"""The graph: whose nodes are whose, who comes and leaves, which ends fit, thousands of names."""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy._rclpy_pybind11 import NodeNameNonExistentError
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool, Float32, String

from archo_tui.robot.graph.endpoints import mismatches
from archo_tui.robot.graph.graph import PERIOD, Resources
from archo_tui.robot.robot import SETTLED, Arrivals
from archo_tui.robot.state.graph import Resource
from archo_tui.screen.widgets.bars import header
from archo_tui.station.history import History
from archo_tui.station.view import View
from tests.support import chosen, clock
from tests.support.alarms import alarms_of
from tests.support.archo import go
from tests.support.plain import operated
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import robot, texts
from tests.support.ros import Ros
from tests.support.stand_in import Made

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


# Whose nodes are whose.


async def test_another_robots_nodes_parameters_and_logs_are_not_its_own() -> None:
    class Other(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("battery_monitor", **options)
            self.declare_parameter("low_battery_threshold", 77.0)
            self.create_timer(0.5, lambda: self.get_logger().error("Goal refused: not yours"))

    namespaces = [["--ros-args", "-r", f"__ns:={namespace}"] for namespace in ("/r2", "/r1")]
    makers = [Made(Other, cli_args=arguments) for arguments in namespaces]
    async with robot(*makers, nodes=1, namespace="/r1") as it:
        await until(lambda: it.snapshot.parameters)
        await until(lambda: it.snapshot.events)
        assert {n.name for n in it.snapshot.nodes} == {"/r1/battery_monitor"}
        assert {p.node for p in it.snapshot.parameters} == {"/r1/battery_monitor"}
        assert {e.source for e in it.snapshot.events} == {"r1.battery_monitor"}
        assert it.snapshot.low_charge == 77.0
        assert it.snapshot.other_namespaces == ("/r2",)


async def test_hidden_nodes_are_not_listed_and_two_of_one_name_are_an_alarm() -> None:
    makers = [Made(Node, name) for name in ("_tool", "twin", "twin")]
    async with robot(*makers, nodes=1) as it:
        await until(lambda: it.snapshot.duplicate_nodes == ("/twin",))
        assert "name twice /twin" in alarms_of(it)
        assert {node.name for node in it.snapshot.nodes} == {"/twin"}


async def test_an_action_of_another_type_is_greyed_with_its_type() -> None:
    domain = chosen.next_domain()
    elsewhere = Ros(domain_id=domain)  # of one process, DDS allows one type a topic
    elsewhere.node("other").create_publisher(String, "move_to_shelf/_action/feedback", 10)
    async with robot(Made(Node, "own"), nodes=2, domain_id=domain) as it:
        await until(lambda: "move_to_shelf" in it.snapshot.faults)
        fault = it.snapshot.faults["move_to_shelf"]
        assert fault.startswith("move_to_shelf is std_msgs/msg/String: expected archo_interfaces/")
        outcome = await ended(go(it, 3))
        assert (outcome.ok, outcome.text) == (False, fault)
    elsewhere.close()


async def test_clients_of_nodes_that_have_gone_are_destroyed() -> None:
    async with robot(Made(Node, "host")) as it:
        await until(lambda: "/host" not in it.snapshot.unreported)
        before = len(it.node._kept_clients)
        for _ in range(3):
            guest = Node("guest", context=it.node.context)
            guest.declare_parameter("x", 1)
            await until(lambda: any(n.name == "/guest" for n in it.snapshot.nodes))
            guest.destroy_node()
            await until(lambda: all(n.name != "/guest" for n in it.snapshot.nodes))
        assert len(it.node._kept_clients) <= before


async def test_nodes_that_come_in_another_namespace_are_seen_from_an_empty_one() -> None:
    async with robot(Made(Node, "own"), namespace="/r1") as it:
        await until(lambda: it.snapshot.parameters)
        begin = clock.seconds()
        await while_passes(3)
        guest = Node("guest", context=it.node.context, namespace="/r2", use_global_arguments=False)
        await until(lambda: it.snapshot.other_namespaces == ("/r2",))
        view = View(it.snapshot, begin, begin, 0.0, "embedded", "/r1", History())
        assert "? robots seen: /r2; use --namespace /r2" in header(view, 120).plain
        guest.destroy_node()


# Who comes and leaves: not those of the start, nor those that run here.

FOUND = {"/lamp", "/tb1/base"}
NAV = {f"/nav/{name}" for name in ("amcl", "bt", "costmap", "drive", "map")}
LATE = [{f"/node_{number}" for number in range(found)} for found in range(10)]
Look = tuple[float, set[str], list[str]]  # When, who is there, and what is told.


@pytest.mark.parametrize(
    ("start", "looks"),
    [
        (
            SETTLED,
            [
                (10.0, {"/lamp"}, ["node tb1/base left"]),
                (11.0, {"/lamp"}, []),
                (12.0, FOUND, ["node tb1/base came"]),
            ],
        ),
        (
            SETTLED,
            [(10.0, FOUND | NAV, ["5 nodes came: nav/amcl, nav/bt, nav/costmap and 2 more"])],
        ),
        # One of those that run here is told by its host alone.
        (SETTLED, [(10.0, FOUND | {"/own"}, []), (11.0, FOUND, []), (12.0, FOUND, [])]),
        (SETTLED, [(10.0, FOUND | {"/own"}, []), (11.0, FOUND, []), (12.0, FOUND | {"/own"}, [])]),
        # It leaves while others of the start come, which are not told however slowly they do.
        (0.0, [(1.0, {"/lamp", "/late"}, ["node tb1/base left"])]),
        (
            0.0,
            [
                *((4.0 * second, FOUND | late, []) for second, late in enumerate(LATE)),
                (36.0 + SETTLED, FOUND | LATE[-1], []),
                (42.0, FOUND | LATE[-1] | {"/fan"}, ["node fan came"]),
            ],
        ),
    ],
)
def test_who_comes_and_leaves_is_told_in_a_line(start: float, looks: list[Look]) -> None:
    arrivals = Arrivals(0.0)
    for now in {0.0, start}:
        assert arrivals.compare(FOUND, (), now) == []
    for now, there, told in looks:
        own = ("/own",) if now == 10.0 else ()  # It has ended here behind that.
        assert arrivals.compare(there, own, now) == told


async def test_a_node_that_visits_the_robot_is_seen_to_come_and_leave() -> None:
    async with robot(Made(Node, "lamp")) as it:
        await while_passes(SETTLED + 2.0)
        visitor = Node("visitor", context=it.node.context)

        def told() -> list[str]:
            return [text for text in texts(it) if text.startswith("node ")]

        await until(lambda: told() == ["node visitor came"])
        visitor.destroy_node()
        await until(lambda: told() == ["node visitor came", "node visitor left"])


# Ends of one topic that do not fit, with what to change.


class Talker(Node):
    def __init__(self, qos: Any = 10, **options: Any) -> None:
        super().__init__("talker", **options)
        self.create_publisher(Float32, "voltage", qos)


TYPES = (
    "hearer hears nothing of talker on /voltage: it subscribes to std_msgs/msg/Bool, "
    "published is std_msgs/msg/Float32. Use one type in both."
)
QOS = (
    "hears nothing of talker on /voltage: it asks for RELIABLE, published is BEST_EFFORT. "
    "Publish RELIABLE, or subscribe with BEST_EFFORT."
)
DURABILITY = (
    "hears nothing of talker on /voltage: it asks for TRANSIENT_LOCAL, published is VOLATILE. "
    "Publish TRANSIENT_LOCAL, or subscribe with VOLATILE."
)


@pytest.fixture(autouse=True)
def _discovers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # two participants


async def test_a_second_subscription_of_a_node_that_is_known_is_seen() -> None:
    talker = Made(Talker, BEST_EFFORT)
    async with robot(talker) as it:
        await until(lambda: any(row.name == "/voltage" for row in it.snapshot.resources))
        talker.node.create_subscription(Float32, "voltage", lambda _: None, 10)
        said = f"talker {QOS}"
        await until(lambda: any(said in row.mismatches for row in it.snapshot.resources))


async def test_topics_lists_the_graph_with_what_does_not_fit_below_while_it_does_not() -> None:
    domain = chosen.next_domain()
    async with operated(Talker, domain_id=domain) as typed:
        elsewhere = Ros(domain_id=domain)  # In one context, ROS 2 refuses a second type.
        try:
            elsewhere.node("hearer").create_subscription(Bool, "voltage", lambda _: None, 10)
            await typed.until(f"WARN console: {TYPES}")
            types = "std_msgs/msg/Bool, std_msgs/msg/Float32"
            await typed.enter("topics", f"topic /voltage {types}, talker\n  {TYPES}\n")
        finally:
            elsewhere.close()
        await until(
            lambda: not any(row.mismatches for row in typed.station.robot.snapshot.resources)
        )
        assert typed.said.count(f"WARN console: {TYPES}") == 1


CELL = "depot_interfaces/msg/CellState"
ONE, OTHER = f"RIHS01_1a2b3c4d{'0' * 56}", f"RIHS01_5e6f7a8b{'0' * 56}"
MISREADS = (
    "may misread talker on /voltage: its depot_interfaces/msg/CellState is another version, hash"
    " 5e6f7a8b, published is 1a2b3c4d. Build both with one version of depot_interfaces."
)


def endpoint(node: str, **changed: Any) -> Any:
    """Return one end of the topic, as rclpy tells of it from Iron on."""
    given = {
        "node_name": node,
        "node_namespace": "/",
        "topic_type": CELL,
        "qos_profile": QoSProfile(depth=1),
    }
    return SimpleNamespace(**{**given, **changed})


def hashed(of: str, **changed: Any) -> dict[str, Any]:
    return {"topic_type_hash": of, **changed}


@pytest.mark.pure
@pytest.mark.parametrize(
    ("published", "hearer", "asked", "said"),
    [
        (hashed(ONE), "hearer", hashed(OTHER), (f"hearer {MISREADS}",)),
        (hashed(ONE), "_tool", hashed(OTHER), ()),  # Hidden.
        (hashed(ONE), "_console", hashed(OTHER), (f"this console {MISREADS}",)),
        (hashed(ONE), "_console", hashed(OTHER, topic_type="std_msgs/msg/Bool"), ()),
        (hashed(ONE), "hearer", hashed(ONE), ()),
        (hashed(ONE), "hearer", hashed("INVALID"), ()),  # Of an end that is older than Iron.
        (hashed("INVALID"), "hearer", hashed(OTHER), ()),
        ({}, "hearer", {}, ()),  # Before Iron, and on the embedded engine.
        # What hears nothing is not said to misread.
        (hashed(ONE, qos_profile=BEST_EFFORT), "hearer", hashed(OTHER), (f"hearer {QOS}",)),
        ({}, "hearer", {"qos_profile": LATCHED}, (f"hearer {DURABILITY}",)),
        ({"qos_profile": LATCHED}, "hearer", {"qos_profile": BEST_EFFORT}, ()),
    ],
)
def test_who_hears_nothing_or_another_version_is_named_with_what_to_change(
    published: Any, hearer: str, asked: Any, said: tuple[str, ...]
) -> None:
    ends = [endpoint("talker", **published)], [endpoint(hearer, **asked)]
    assert mismatches("/voltage", *ends, "/_console") == said


# A graph of thousands of names: little is asked at a look, and all of it is found in time.

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


def test_what_comes_is_seen_at_the_next_look_what_leaves_within_30_s() -> None:
    graph = Graph(200)
    graph.publishes["n0"].append("/n1/t0")
    graph.nameless = {"/bare", "/bare_service"}  # No node is known for these.
    looks = Looks(graph)
    looks.look()
    assert looks.nodes("/n1/t0") == ("/n0", "/n1")
    assert looks.nodes("/bare") == ("/_NODE_NAME_UNKNOWN_",)
    row = looks.row("/bare_service")
    assert row is not None
    assert row.nodes == ()
    graph.publishes["n77"].append("/new")
    graph.serves["n78"].append("/do")
    graph.publishes["n1"].remove("/n1/t0")
    looks.look()
    assert (looks.nodes("/new"), looks.nodes("/do")) == (("/n77",), ("/n78",))
    for _ in range(PERIOD):
        looks.look()
    assert looks.nodes("/n1/t0") == ("/n0",)
    graph.nodes.remove("n0")
    looks.look()
    assert looks.nodes("/n1/t0") == ()
    assert looks.row("/n0/s") is None


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
