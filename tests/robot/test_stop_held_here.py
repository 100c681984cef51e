"""A STOP is held by nobody only once every node that can hold it has ended in this process."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import pytest

from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Latch, StopAnswer
from archo_tui.robot.stop.machine import Result, Servers, Stop

pytestmark = pytest.mark.pure

HERE, ELSEWHERE, NAMESAKE = b"1", b"2", b"3"  # The ids of nodes.


class Nodes:
    """A STOP that holds, and the nodes that serve it.

    Attributes:
        stop: The state of the machine.
        unended: The nodes of this process whose code may still run.
    """

    def __init__(self, **served: bytes | set[bytes]) -> None:
        self.unended = ["motor"]
        self.stop = Stop()
        self._turns = itertools.count(1)
        self.confirm(**served)

    def confirm(self, **served: bytes | set[bytes]) -> None:
        """All nodes that serve STOP say yes to a call."""
        turn, servers = next(self._turns), _servers(served)
        called = self.stop.calling(turn, 0.0, is_pressed=True).leaving(next(self._turns), servers)
        yes = Result(StopAnswer.AWAITED)
        self.stop = called.answered_by(
            yes, turn, 0.0, next(self._turns), servers, servers, self.unended
        )

    def move(self, motion: Motion, **served: bytes | set[bytes]) -> None:
        self.stop = self.stop.moved(motion, 9.0, _servers(served), self.unended)

    def look(self, **served: bytes | set[bytes]) -> bool:
        """Return whether nobody holds the STOP once these nodes serve it."""
        self.stop = self.stop.served_by(_servers(served), self.unended, 9.0)
        return self.stop.is_held_by_nobody


def _servers(served: Mapping[str, bytes | set[bytes]]) -> Servers:
    return frozenset(
        (node, frozenset(ids if isinstance(ids, set) else {ids})) for node, ids in served.items()
    )


def test_one_whose_node_ran_here_and_has_ended_is_held_by_nobody() -> None:
    nodes = Nodes(motor=HERE)
    nodes.unended = []
    assert not nodes.look(motor=HERE)  # It is still on the graph.
    assert nodes.look()


def test_a_last_report_of_nodes_that_have_ended_does_not_put_them_elsewhere() -> None:
    nodes = Nodes(motor=HERE)
    nodes.unended = []
    assert nodes.look()
    nodes.move(Motion(stopped=True))
    assert nodes.look()


def test_one_whose_node_has_ended_and_that_was_released_elsewhere_is_uncertain() -> None:
    nodes = Nodes(motor=HERE)
    nodes.move(Motion(stopped=True))  # A robot that reports its stops.
    nodes.unended = []
    assert nodes.look()
    nodes.stop = nodes.stop.released_elsewhere("other", 9, 9.0)
    assert nodes.stop.latch is Latch.UNCERTAIN
    assert nodes.look()


def test_what_moves_behind_a_release_is_not_said_to_disobey() -> None:
    nodes = Nodes(motor=HERE)
    nodes.move(Motion(moving=True, received=5.0))
    assert nodes.stop.is_not_obeyed
    nodes.stop = nodes.stop.release_accepted(9, 9.0, 10)
    assert not nodes.stop.is_not_obeyed


def test_one_whose_node_has_left_but_is_not_ended_is_held() -> None:
    nodes = Nodes(motor=HERE)
    assert not nodes.look()  # Its program is suspended: it returns, and holds the STOP.
    assert not nodes.look(motor=HERE)
    nodes.unended = []
    assert nodes.look()


def test_one_of_an_ended_nodes_namesake_elsewhere_is_held() -> None:
    nodes = Nodes(motor=HERE)
    nodes.unended = []
    nodes.confirm(motor=ELSEWHERE)
    assert not nodes.look()


def test_one_of_two_nodes_of_one_name_is_held() -> None:
    nodes = Nodes(motor={HERE, NAMESAKE})
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
    nodes.stop = nodes.stop.carried_out_early("motor")
    assert not nodes.look(motor=NAMESAKE)
    nodes.unended = []
    assert nodes.look()
