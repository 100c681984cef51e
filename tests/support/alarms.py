"""The alarms whose conditions hold in a state."""

from __future__ import annotations

from typing import Any

from archo_tui.robot.robot import Robot
from archo_tui.robot.state.snapshot import Hosted, Snapshot
from archo_tui.station import conditions as alarms
from archo_tui.station.conditions import Situation
from tests.support.clock import seconds


def conditions(
    snapshot: Snapshot, now: float, hosted: tuple[Hosted, ...] = (), **more: Any
) -> dict[str, str]:
    """Their texts by their names."""
    return alarms.conditions(Situation(snapshot, now, hosted, **more)).texts


def alarms_of(robot: Robot) -> dict[str, str]:
    """Their texts by their names, as the robot is now."""
    return conditions(robot.snapshot, seconds())
