"""A reason that was given is taken away when what it may be about is over."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.graph import Parameter
from archo_tui.robot.state.readings import Battery, GaugeReading, Motion
from archo_tui.robot.state.snapshot import Latch, Snapshot
from archo_tui.robot_file.model import Gauge, MessageField
from archo_tui.station.reason import CauseWatch, limits, refusal_causes
from tests.support.archo import ARCHO
from tests.support.states import BATTERY, MOVING, STATES

THERE = Snapshot(file=ARCHO, offered=frozenset({"move_to_shelf"}), battery=BATTERY)
HOT = GaugeReading(Gauge("Temperature", "heat", "std_msgs/msg/Float32", MessageField("data")), 71.0)


def shelves(count: int) -> tuple[Parameter, ...]:
    return (Parameter("/motor_controller", "shelf_count", "integer", count, 40),)


@pytest.mark.parametrize(
    ("then", "now"),
    [
        ({"battery": Battery(0.0)}, {"battery": Battery(0.4, charging=True)}),
        ({"battery": Battery(19.0)}, {"battery": Battery(20.0)}),
        ({"battery": BATTERY._replace(charging=True)}, {}),
        ({"battery": BATTERY._replace(health="replace")}, {}),
        ({"motion": Motion(stopped=True)}, {"motion": Motion(stopped=False)}),
        ({"latch": Latch.UNCERTAIN}, {}),
        ({"motion": Motion(moving=True)}, {"motion": Motion(moving=False)}),
        ({"offered": frozenset()}, {}),
        ({}, {"offered": frozenset()}),
        ({"goal": MOVING}, {"goal": MOVING._replace(phase=Phase.ARRIVED)}),
        ({"goal": MOVING._replace(phase=Phase.LOST)}, {"goal": MOVING}),
        ({"goal": MOVING}, {"goal": MOVING._replace(sent=MOVING.sent + 1)}),
        ({"running": 2}, {"running": 1}),
        ({"parameters": shelves(4)}, {"parameters": shelves(5)}),
        (
            {"gauges": (HOT._replace(gauge=replace(HOT.gauge, warn_above=60.0)),)},
            {"gauges": (HOT._replace(gauge=replace(HOT.gauge, warn_above=60.0), value=41.0),)},
        ),
    ],
)
def test_a_refusal_is_over_when_a_cause_that_it_may_have_is(
    then: dict[str, Any], now: dict[str, Any]
) -> None:
    refusal = CauseWatch(refusal_causes)
    assert not refusal.observe(THERE._replace(**then))
    assert not refusal.observe(THERE._replace(**then))
    assert refusal.observe(THERE._replace(**now))


def test_a_cause_that_is_reported_behind_its_refusal_ends_nothing_until_it_is_over() -> None:
    refusal = CauseWatch(refusal_causes)
    assert not refusal.observe(THERE)
    assert not refusal.observe(THERE._replace(motion=Motion(stopped=True)))
    assert refusal.observe(THERE)


def test_readings_that_go_on_as_they_were_end_no_refusal() -> None:
    refusal = CauseWatch(refusal_causes)
    for charge in (87.5, 87.4, 87.3):
        assert not refusal.observe(THERE._replace(battery=BATTERY._replace(percentage=charge)))


def test_a_number_out_of_range_is_judged_anew_only_when_the_range_changes() -> None:
    typed = CauseWatch(limits)
    assert not typed.observe(THERE._replace(parameters=shelves(40)))
    empty = STATES["battery empty"].battery
    assert not typed.observe(THERE._replace(parameters=shelves(40), battery=empty))
    assert typed.observe(THERE._replace(parameters=shelves(50)))
