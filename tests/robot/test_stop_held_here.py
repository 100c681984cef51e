"""A STOP is held by nobody only once every node that can hold it has ended in this process."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from archo_tui.clock import Clock
from archo_tui.robot.state import Motion
from archo_tui.robot.stop_latch import StopLatch

HERE, ELSEWHERE, NAMESAKE = b"1", b"2", b"3"  # The ids of nodes.


class Nodes:
    """A latch, and the nodes that serve the STOP.

    Attributes:
        served: The ids of each node that serves it, by its name.
        unended: The nodes of this process whose code may still run.
    """

    def __init__(self, **served: bytes) -> None:
        self.served = {node: {ids} for node, ids in served.items()}
        self.unended = ["motor"]
        graph: Any = SimpleNamespace(holders=lambda _: self._holders())
        self.latch = StopLatch("stop", Clock(), graph, lambda: self.unended, lambda: None)
        self.latch.hold()

    def _holders(self) -> dict[str, frozenset[bytes]]:
        return {node: frozenset(ids) for node, ids in self.served.items()}

    def look(self, **served: bytes) -> bool:
        """Return whether nobody holds the STOP once these nodes serve it."""
        self.served = {node: {ids} for node, ids in served.items()}
        self.latch.check_holders()
        return self.latch.holders_have_ended


def test_one_whose_node_ran_here_and_has_ended_is_held_by_nobody() -> None:
    nodes = Nodes(motor=HERE)
    nodes.unended = []
    assert not nodes.look(motor=HERE)  # It is still on the graph.
    assert nodes.look()


def test_a_last_report_of_nodes_that_have_ended_does_not_put_them_elsewhere() -> None:
    nodes = Nodes(motor=HERE)
    nodes.latch.sent_to = {"motor": frozenset({HERE})}
    nodes.unended = []
    assert nodes.look()
    nodes.latch.on_motion(Motion(stopped=True))
    assert nodes.look()


def test_one_that_was_released_elsewhere_is_over_and_held_by_nobody_no_more() -> None:
    nodes = Nodes()
    nodes.served = {"motor": {HERE}}
    nodes.latch.on_motion(Motion(stopped=False))  # A robot that reports its stops.
    nodes.latch.hold()
    nodes.unended = []
    assert nodes.look()
    nodes.latch.on_released_elsewhere("other")
    assert not nodes.look()


def test_what_moves_behind_a_release_is_not_said_to_disobey() -> None:
    nodes = Nodes()
    nodes.latch.expect_standstill(0.0)
    nodes.latch.on_motion(Motion(moving=True, received=5.0))
    assert nodes.latch.is_not_obeyed
    nodes.latch.release()
    assert not nodes.latch.is_not_obeyed


def test_one_whose_node_has_left_but_is_not_ended_is_held() -> None:
    nodes = Nodes(motor=HERE)
    assert not nodes.look()  # Its program is suspended: it returns, and holds the STOP.
    assert not nodes.look(motor=HERE)
    nodes.unended = []
    assert nodes.look()


def test_one_of_an_ended_nodes_namesake_elsewhere_is_held() -> None:
    nodes = Nodes()
    nodes.unended = []
    nodes.served = {"motor": {ELSEWHERE}}
    nodes.latch.hold()
    assert not nodes.look()


def test_one_of_two_nodes_of_one_name_is_held() -> None:
    nodes = Nodes()
    nodes.served = {"motor": {HERE, NAMESAKE}}
    nodes.latch.hold()
    nodes.unended = []
    assert not nodes.look()


def test_one_that_a_node_elsewhere_may_have_got_since_is_held() -> None:
    nodes = Nodes(motor=HERE)
    assert not nodes.look(motor=HERE, other=ELSEWHERE)
    nodes.unended = []
    assert not nodes.look(other=ELSEWHERE)
    assert not nodes.look()


def test_one_of_a_node_started_anew_here_is_held_by_nobody_at_its_end() -> None:
    nodes = Nodes(motor=HERE)
    assert not nodes.look(motor=NAMESAKE)
    nodes.latch.add_stopped_early("motor")
    nodes.unended = []
    assert nodes.look()
