"""`status --line` in a prompt or a status line: never healthier than the screen."""

from __future__ import annotations

from typing import Any

import pytest

from archo_tui.robot.state.snapshot import Hosted, Life, Snapshot
from archo_tui.verbs.as_json import in_line
from tests.support.states import NORMAL, STATES
from tests.support.stub import StandingClock, StubRobot, stub_station


def line(snapshot: Snapshot, *hosted: Hosted) -> str:
    """What it says of a robot in that state for some seconds."""
    robot: Any = StubRobot(snapshot)
    clock = StandingClock()
    station = stub_station(robot, clock, hosted)
    for clock.passed in (0.0, 2.1):
        station.on_snapshot(snapshot)
    clock.passed = 0.0
    return in_line(station)


STILL_RUNNING = STATES["motor stopped"]._replace(still_running_after_stop=("shelf 12",))
CRASHED = Hosted("/dashboard", Life.CRASHED, "ZeroDivisionError: division by zero")


@pytest.mark.parametrize(
    ("snapshot", "hosted", "said"),
    [
        (NORMAL, (), "ARCHO 88 % IDLE"),
        (STATES["battery old"], (), "ARCHO -- % IDLE"),
        (NORMAL, (CRASHED,), "ARCHO 88 % IDLE alarm: node crashed /dashboard"),
        (STILL_RUNNING, (), "ARCHO 88 % STOPPED alarm: moves after stop"),
        (STATES["battery empty"], (), "ARCHO 0 % IDLE alarm: battery empty"),
    ],
)
def test_the_gravest_alarms_are_named_in_a_line(
    snapshot: Snapshot, hosted: tuple[Hosted, ...], said: str
) -> None:
    assert line(snapshot, *hosted) == said
