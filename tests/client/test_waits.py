"""What `wait` waits for: never over by what was once known, and may be otherwise now."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Latch, Snapshot
from archo_tui.verbs import verbs
from archo_tui.verbs.verb import TIMEOUT
from tests.support.states import NORMAL, STATES
from tests.support.stub import StandingClock, StubRobot, stub_station


async def waited(snapshot: Snapshot, words: str) -> Outcome | None:
    """How it ends at once; None: it goes on."""
    robot: Any = StubRobot(snapshot)
    clock = StandingClock()
    station = stub_station(robot, clock)
    station.on_snapshot(snapshot)
    clock.passed = 2.1  # long enough for an alarm
    station.on_snapshot(snapshot)
    clock.passed = 0.0
    wait = verbs(snapshot.file, snapshot.forms)["wait"]
    outcome = await wait.run(station, {**wait.values(words.split()), TIMEOUT: 0})
    return None if outcome.code is Code.RAN_OUT else outcome


@pytest.mark.parametrize("words", ["idle", "ready", "battery 80"])
async def test_a_healthy_robot_is_waited_for_no_more(words: str) -> None:
    outcome = await waited(NORMAL, words)
    assert outcome is not None
    assert outcome.code == Code.DONE


@pytest.mark.parametrize(
    ("state", "words"),
    [
        ("battery old", "battery 80"),
        ("contact lost", "battery 10"),
        ("contact lost", "ready"),
        ("contact lost", "idle"),
        ("nothing heard yet", "idle"),
        ("nothing heard yet", "ready"),
        ("battery empty", "ready"),
        ("motor stopped", "ready"),
        ("motor stop not confirmed", "ready"),
        ("normal", "stopped"),
        ("motor stop not confirmed", "stopped"),
        ("contact lost", "stopped"),
        ("nothing heard yet", "stopped"),
    ],
)
async def test_a_sick_robot_is_waited_for_on(state: str, words: str) -> None:
    assert await waited(STATES[state], words) is None


@pytest.mark.parametrize(
    "motion",
    [{"moving": True}, {"received": None}, {"received": NORMAL.motion.received - 60.0}],  # type: ignore[operator]
)
async def test_a_robot_that_moves_without_a_goal_or_is_silent_is_not_idle(
    motion: dict[str, Any],
) -> None:
    moved = NORMAL._replace(motion=replace(NORMAL.motion, **motion))
    assert await waited(moved, "idle") is None
    if "received" in motion:
        assert await waited(moved, "ready") is None


async def test_wait_stopped_ends_when_the_robot_reports_the_stop() -> None:
    stopped = STATES["motor stopped"]
    told = await waited(stopped, "stopped")
    assert told is not None
    assert (told.ok, told.text) == (True, "stopped")
    rolls = stopped._replace(motion=replace(stopped.motion, moving=True))
    assert await waited(rolls, "stopped") is None


async def test_of_a_robot_that_reports_no_stop_the_confirmed_one_counts() -> None:
    motion = NORMAL.file.motion
    assert motion is not None
    types = {name: replace(kind, stopped=None) for name, kind in motion.types.items()}
    file = replace(NORMAL.file, motion=replace(motion, types=types))
    mute = NORMAL._replace(file=file, motion=replace(NORMAL.motion, stopped=None))
    assert await waited(mute, "stopped") is None
    assert await waited(mute._replace(latch=Latch.HELD), "stopped") is not None
