"""What verbs make of a state of the robot: `wait`, `status --line`, and the words at a tab."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.graph import Parameter
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Hosted, Latch, Life, Snapshot
from archo_tui.station.station import Station
from archo_tui.verbs import verbs
from archo_tui.verbs.as_json import in_line, state
from archo_tui.verbs.verb import TIMEOUT, candidates
from tests.support.clock import TIME
from tests.support.console import screen_text
from tests.support.quiet import Quiet
from tests.support.states import MOVING, NORMAL, STATES
from tests.support.stub import StandingClock, StubRobot, stub_app, stub_station


def station_of(snapshot: Snapshot, *hosted: Hosted) -> Station:
    """A robot that has been in that state for long enough for an alarm."""
    clock = StandingClock()
    station = stub_station(StubRobot(snapshot), clock, hosted)
    for clock.passed in (0.0, 2.1):
        station.on_snapshot(snapshot)
    clock.passed = 0.0
    return station


async def waited(snapshot: Snapshot, words: str) -> Outcome | None:
    """How it ends at once; None: it goes on."""
    wait = verbs(snapshot.file, snapshot.forms)["wait"]
    outcome = await wait.run(station_of(snapshot), {**wait.values(words.split()), TIMEOUT: 0})
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
        ("contact lost", "ready"),
        ("contact lost", "idle"),
        ("nothing heard yet", "idle"),
        ("battery empty", "ready"),
        ("motor stopped", "ready"),
        ("motor stop not confirmed", "ready"),
        ("normal", "stopped"),
        ("motor stop not confirmed", "stopped"),
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


STILL_RUNNING = STATES["motor stopped"]._replace(still_running_after_stop=("shelf 12",))
BLIND = NORMAL._replace(
    file=replace(NORMAL.file, motion=None), motion=Motion(), latch=Latch.HELD, latch_time=TIME
)


async def test_a_robot_whose_goal_runs_on_behind_a_stop_is_not_called_stopped() -> None:
    assert await waited(STILL_RUNNING, "stopped") is None
    assert await waited(BLIND, "stopped") is not None
    driving = BLIND._replace(goal=MOVING)
    for blind in (driving, driving._replace(still_running_after_stop=("shelf 12",))):
        assert await waited(blind, "stopped") is None
    runs = BLIND._replace(goal=MOVING, still_running_after_stop=("shelf 12",))
    for snapshot in (STILL_RUNNING, runs):
        assert state(station_of(snapshot))["motion"]["stopped"] is None
        app = stub_app(snapshot, StandingClock())
        async with app.run_test(size=(120, 36)):
            await Quiet(app).settle()
            assert "✗ STOPPED" not in screen_text(app)
            assert screen_text(app).count("✗ A GOAL STILL RUNS") == 2  # Above, and in its panel.
            app._on_snapshot(snapshot._replace(stop_not_obeyed=True))
            await Quiet(app).settle()
            assert screen_text(app).count("✗ STILL MOVING") == 2


def test_an_acknowledged_alarm_stays_so_while_a_goal_runs_on() -> None:
    station = station_of(STATES["motor stopped"])
    station.acknowledge(station.view.alarms)
    for snapshot in (STILL_RUNNING, STATES["motor stopped"]):
        station.on_snapshot(snapshot)
        stopped = next(alarm for alarm in station.view.alarms if alarm.name == "stopped")
        assert stopped.acknowledged
        assert stopped.text.startswith("STOPPED") == (snapshot is not STILL_RUNNING)


async def test_of_a_robot_that_reports_no_stop_the_confirmed_one_counts() -> None:
    motion = NORMAL.file.motion
    assert motion is not None
    types = {name: replace(kind, stopped=None) for name, kind in motion.types.items()}
    file = replace(NORMAL.file, motion=replace(motion, types=types))
    mute = NORMAL._replace(file=file, motion=replace(NORMAL.motion, stopped=None))
    assert await waited(mute, "stopped") is None
    assert await waited(mute._replace(latch=Latch.HELD), "stopped") is not None


CRASHED = Hosted("/dashboard", Life.CRASHED, "ZeroDivisionError: division by zero")


@pytest.mark.parametrize(
    ("snapshot", "hosted", "said"),
    [
        (NORMAL, (), "ARCHO 88 % IDLE"),
        (STATES["battery old"], (), "ARCHO -- % IDLE"),
        (NORMAL, (CRASHED,), "ARCHO 88 % IDLE alarm: node crashed /dashboard"),
        (STILL_RUNNING, (), "ARCHO 88 % A GOAL STILL RUNS alarm: moves after stop"),
        (STATES["battery empty"], (), "ARCHO 0 % IDLE alarm: battery empty"),
    ],
)
def test_the_gravest_alarms_are_named_in_a_line(
    snapshot: Snapshot, hosted: tuple[Hosted, ...], said: str
) -> None:
    assert in_line(station_of(snapshot, *hosted)) == said


# at a tab

KNOWN = NORMAL._replace(
    parameters=(*NORMAL.parameters, Parameter("/dashboard", "quiet", "bool", False, False)),
    services={"/reset_encoder": ("archo_interfaces/srv/ResetEncoder",)},
    actions={"/move_to_shelf": ("archo_interfaces/action/MoveToShelf",)},
)
SHELVES = Parameter("/motor_controller", "shelf_count", "integer", 12, 12)


def offered(*words: str, snapshot: Snapshot = KNOWN) -> list[str]:
    """What is offered for the last word."""
    return candidates(verbs(snapshot.file, snapshot.forms), station_of(snapshot), words)


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (("st",), ["stop", "status", "start"]),
        (("set", "motor"), ["motor_controller"]),
        (("get", "motor_controller", "max"), ["max_speed"]),
        (("get", "motor_controller", "max_speed", ""), []),
        (("set", "max"), ["max_speed"]),
        (("set", "dashboard", "quiet", ""), ["false", "true"]),
        (("echo", "bat"), ["battery_drain", "battery_level"]),
        (("call", "re"), ["reset_encoder"]),
        (("send_goal", ""), ["move_to_shelf"]),
        (("interface", "std_msgs"), ["std_msgs/msg/Float32"]),
        (("log_level", "motor_controller", "wa"), ["warn"]),
        (("lifecycle", "any", "act"), ["activate"]),
        (("wait", "i"), ["idle"]),
        (("stop", ""), []),
        (("cancel", "--a"), ["--all"]),
    ],
)
def test_a_word_is_offered_that_the_console_would_take(
    words: tuple[str, ...], wanted: list[str]
) -> None:
    assert offered(*words) == wanted


def test_the_shelves_are_offered_that_the_robot_reports() -> None:
    shelves = NORMAL._replace(parameters=(SHELVES,))
    assert offered("go", "", snapshot=shelves) == [str(shelf) for shelf in range(1, 13)]
    assert offered("go", "12", "1", snapshot=shelves) == ["1", "10", "11", "12"]
    assert offered("go", "13", snapshot=shelves) == []
    assert offered("go", "", snapshot=NORMAL._replace(parameters=())) == []
