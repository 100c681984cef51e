"""Endpoints of one topic that do not fit are named, with what to change."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool, Float32

from archo_tui.robot.graph.endpoints import mismatches
from tests.support import chosen
from tests.support.plain import operated
from tests.support.quiet import until
from tests.support.robot import making, robot
from tests.support.ros import Ros

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


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
    made: list[Any] = []
    domain = chosen.next_domain()
    async with robot(making(made, Talker, published), domain_id=domain) as it:

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
    made: list[Any] = []
    async with robot(making(made, Talker, BEST_EFFORT)) as it:
        await until(lambda: any(row.name == "/voltage" for row in it.snapshot.resources))
        made[0].create_subscription(Float32, "voltage", lambda _: None, 10)
        said = QOS.replace("hearer", "talker")
        await until(lambda: any(said in row.mismatches for row in it.snapshot.resources))


async def test_topics_lists_the_graph_with_what_does_not_fit_below() -> None:
    made: list[Any] = []
    domain = chosen.next_domain()
    async with operated(making(made, Talker), domain_id=domain) as typed:
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


@pytest.mark.parametrize(
    ("published", "asked", "found"),
    [
        (ONE, OTHER, (f"hearer {MISREADS}",)),
        (ONE, ONE, ()),
        (ONE, "INVALID", ()),  # of a publisher or subscription that is older than Iron
        ("INVALID", OTHER, ()),
    ],
)
def test_two_versions_of_one_type_are_named_by_node_and_hash(
    published: str, asked: str, found: tuple[str, ...]
) -> None:
    publisher = endpoint("power", topic_type_hash=published)
    hearer = endpoint("hearer", topic_type_hash=asked)
    hidden = endpoint("_tool", topic_type_hash=asked)
    assert mismatches("/cell", [publisher], [hearer, hidden], "/_console") == found


def test_another_version_that_this_console_reads_is_said_too() -> None:
    publisher = endpoint("power", topic_type_hash=ONE)
    console = endpoint("_console", topic_type_hash=OTHER)
    said = mismatches("/cell", [publisher], [console], "/_console")
    assert said == (f"this console {MISREADS}",)
    console.topic_type = "std_msgs/msg/Bool"  # which its reader says
    assert mismatches("/cell", [publisher], [console], "/_console") == ()


def test_what_hears_nothing_is_not_said_to_misread() -> None:
    publisher = endpoint("power", topic_type_hash=ONE, qos_profile=BEST_EFFORT)
    hearer = endpoint("hearer", topic_type_hash=OTHER)
    (said,) = mismatches("/cell", [publisher], [hearer])
    assert "hears nothing of power" in said


def test_before_iron_and_on_the_embedded_engine_no_hash_is_told() -> None:
    assert mismatches("/cell", [endpoint("power")], [endpoint("hearer")]) == ()
