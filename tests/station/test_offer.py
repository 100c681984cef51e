"""A console on another robot than ARCHO, without a file for it, says how one is written."""

from __future__ import annotations

from typing import Any

from archo_tui.robot.state.graph import NodeState
from archo_tui.robot.state.snapshot import Snapshot
from tests.support.states import NORMAL
from tests.support.stub import StandingClock, StubRobot, stub_station

OTHER = NORMAL._replace(offered=frozenset(), nodes=(NodeState("/base"),))


def offers(snapshot: Snapshot, seconds: float = 6.0, **options: Any) -> list[str]:
    robot: Any = StubRobot(snapshot)
    said: list[str] = []
    robot.note = lambda level, source, text: said.append(f"{level} {text}")
    clock = StandingClock()
    station = stub_station(robot, clock, **{"attached": True, "file_is_default": True, **options})
    station.on_snapshot(snapshot)
    clock.passed = seconds
    for _ in range(3):
        station.tick()
    return said


def test_it_says_once_how_a_robot_file_is_written() -> None:
    (said,) = offers(OTHER)
    assert said.startswith("WARN this robot is not ARCHO, and no --robot names its file")
    assert "Describe this robot" in said


def test_it_says_nothing_to_who_needs_nothing() -> None:
    assert offers(NORMAL) == []  # ARCHO
    assert offers(OTHER, seconds=2.0) == []  # its nodes may still come
    assert offers(OTHER, file_is_default=False) == []
    assert offers(OTHER, attached=False) == []
    assert offers(OTHER._replace(nodes=())) == []
