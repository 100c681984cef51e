"""Nodes that come and leave are events, but for those of the start and those that run here."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.robot.robot import SETTLED, Arrivals
from tests.support.clock import seconds
from tests.support.plain import operated
from tests.support.quiet import until
from tests.support.robot import robot

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


class Lamp(Node):
    def __init__(self, **options: Any) -> None:
        super().__init__("lamp", **options)


async def test_a_node_that_visits_the_robot_is_seen_to_come_and_leave() -> None:
    async with robot(Lamp) as it:
        began = seconds()
        await until(lambda: seconds() > began + SETTLED + 2.0)
        visitor = Node("visitor", context=it.node.context)

        def told() -> list[str]:
            return [e.text for e in it.snapshot.events if e.text.startswith("node ")]

        await until(lambda: told() == ["node visitor came"])
        visitor.destroy_node()
        await until(lambda: told() == ["node visitor came", "node visitor left"])


async def test_a_node_that_the_operator_stops_and_starts_is_told_once() -> None:
    async with operated(Lamp) as person:
        began = seconds()
        await until(lambda: seconds() > began + SETTLED + 2.0)
        it = person._plain._station.robot

        def nodes() -> list[str]:
            return [node.name for node in it.snapshot.nodes]

        person.type("halt lamp\n")
        await until(lambda: nodes() == [])
        person.type("start lamp\n")
        await until(lambda: nodes() == ["/lamp"])
        assert await person.end("events\n") == 0
    assert "YOU console: start /lamp" in person.said
    assert "node lamp" not in person.said
