"""The graph: whose nodes are whose, who comes and leaves, which ends fit, thousands of names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
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


async def test_an_action_of_another_type_is_greyed_with_its_type(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # two participants
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


def settled() -> Arrivals:
    """One that has seen all nodes of the start."""
    arrivals = Arrivals(0.0)
    assert arrivals.compare(FOUND, (), 0.0) == []
    assert arrivals.compare(FOUND, (), SETTLED) == []
    return arrivals


def test_a_node_that_leaves_or_comes_is_a_line() -> None:
    arrivals = settled()
    assert arrivals.compare({"/lamp"}, (), 10.0) == ["node tb1/base left"]
    assert arrivals.compare({"/lamp"}, (), 11.0) == []
    assert arrivals.compare(FOUND, (), 12.0) == ["node tb1/base came"]


def test_nodes_of_the_start_are_not_told_however_slowly_they_are_found() -> None:
    arrivals, found = Arrivals(0.0), set[str]()
    for second in range(0, 40, 4):
        found.add(f"/node_{second}")
        assert arrivals.compare(found, (), float(second)) == []
    assert arrivals.compare(found, (), 36.0 + SETTLED) == []
    assert arrivals.compare({*found, "/lamp"}, (), 42.0) == ["node lamp came"]


def test_one_that_leaves_while_others_of_the_start_come_is_told() -> None:
    arrivals = Arrivals(0.0)
    arrivals.compare(FOUND, (), 0.0)
    assert arrivals.compare({"/lamp", "/late"}, (), 1.0) == ["node tb1/base left"]


def test_many_at_once_are_one_line() -> None:
    arrivals = settled()
    stack = {f"/nav/{name}" for name in ("amcl", "bt", "costmap", "drive", "map")}
    assert arrivals.compare(FOUND | stack, (), 10.0) == [
        "5 nodes came: nav/amcl, nav/bt, nav/costmap and 2 more"
    ]


@pytest.mark.parametrize("there", [FOUND, FOUND | {"/own"}])
def test_a_node_that_runs_here_is_told_by_its_host_alone(there: set[str]) -> None:
    arrivals = settled()
    assert arrivals.compare(FOUND | {"/own"}, ("/own",), 10.0) == []
    assert arrivals.compare(FOUND, (), 11.0) == []
    assert arrivals.compare(there, (), 12.0) == []


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


HEARS_NOTHING = "hearer hears nothing of talker on /voltage: "


TYPES = (
    f"{HEARS_NOTHING}it subscribes to std_msgs/msg/Bool, published is std_msgs/msg/Float32."
    " Use one type in both."
)


QOS = (
    f"{HEARS_NOTHING}it asks for RELIABLE, published is BEST_EFFORT."
    " Publish RELIABLE, or subscribe with BEST_EFFORT."
)


DURABILITY = (
    f"{HEARS_NOTHING}it asks for TRANSIENT_LOCAL, published is VOLATILE."
    " Publish TRANSIENT_LOCAL, or subscribe with VOLATILE."
)


@pytest.fixture(autouse=True)
def _discovers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # two participants


@contextmanager
def hearing(domain: int, kind: Any, qos: Any) -> Iterator[None]:
    """Have a node subscribe in a context of its own: in one, ROS 2 refuses a second type."""
    elsewhere = Ros(domain_id=domain)
    try:
        elsewhere.node("hearer").create_subscription(kind, "voltage", lambda _: None, qos)
        yield
    finally:
        elsewhere.close()


@pytest.mark.parametrize(
    ("published", "kind", "asked", "said"),
    [
        (10, Bool, 10, TYPES),
        (BEST_EFFORT, Float32, 10, QOS),
        (10, Float32, LATCHED, DURABILITY),
        (LATCHED, Float32, BEST_EFFORT, ""),
    ],
)
async def test_who_hears_nothing_is_named_and_what_to_change(
    published: Any, kind: Any, asked: Any, said: str
) -> None:
    domain = chosen.next_domain()
    async with robot(Made(Talker, published), domain_id=domain) as it:

        def found() -> tuple[str, ...] | None:
            """Return what is wrong with the topic; None while it is not seen."""
            rows = [row for row in it.snapshot.resources if row.name == "/voltage"]
            return rows[0].mismatches if rows else None

        with hearing(domain, kind, asked):
            await until(lambda: len(it.snapshot.nodes) == 2)
            if said:
                await until(lambda: found() == (said,))
                await until(lambda: any(event.text == said for event in it.snapshot.events))
                events = [event for event in it.snapshot.events if event.text == said]
                assert [(event.level, event.count) for event in events] == [("WARN", 1)]
            else:
                await until(lambda: found() is not None)
                assert found() == ()
        await until(lambda: found() == ())


async def test_a_second_subscription_of_a_node_that_is_known_is_seen() -> None:
    talker = Made(Talker, BEST_EFFORT)
    async with robot(talker) as it:
        await until(lambda: any(row.name == "/voltage" for row in it.snapshot.resources))
        talker.node.create_subscription(Float32, "voltage", lambda _: None, 10)
        said = QOS.replace("hearer", "talker")
        await until(lambda: any(said in row.mismatches for row in it.snapshot.resources))


async def test_topics_lists_the_graph_with_what_does_not_fit_below() -> None:
    domain = chosen.next_domain()
    async with operated(Talker, domain_id=domain) as typed:
        with hearing(domain, Bool, 10):
            await typed.until(f"WARN console: {TYPES}")
            typed.type("topics\n")
            types = "std_msgs/msg/Bool, std_msgs/msg/Float32"
            await typed.until(f"topic /voltage {types}, talker\n  {TYPES}\n")


CELL = "depot_interfaces/msg/CellState"


ONE, OTHER = f"RIHS01_1a2b3c4d{'0' * 56}", f"RIHS01_5e6f7a8b{'0' * 56}"


MISREADS = (
    "may misread power on /cell: its depot_interfaces/msg/CellState is another version, hash"
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
    ],
)
def test_two_versions_of_one_type_are_named_by_node_and_hash(
    published: Any, hearer: str, asked: Any, said: tuple[str, ...]
) -> None:
    ends = [endpoint("power", **published)], [endpoint(hearer, **asked)]
    assert mismatches("/cell", *ends, "/_console") == said


@pytest.mark.pure
def test_what_hears_nothing_is_not_said_to_misread() -> None:
    publisher = endpoint("power", topic_type_hash=ONE, qos_profile=BEST_EFFORT)
    (said,) = mismatches("/cell", [publisher], [endpoint("hearer", topic_type_hash=OTHER)])
    assert "hears nothing of power" in said


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
