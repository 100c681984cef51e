"""Clocks that differ: which stamps count, and when the alarm is over."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from archo_tui.robot.clock_offsets import ClockOffsets
from archo_tui.station.alarm_conditions import conditions
from tests.support.clock import NOW
from tests.support.states import NORMAL


def stamp(seconds: float) -> Any:
    return SimpleNamespace(sec=int(seconds), nanosec=int(seconds % 1 * 1e9))


def test_three_stamps_that_are_off_are_a_large_offset() -> None:
    offsets = ClockOffsets()
    assert not offsets.add("/base", stamp(97.0), 100.0)
    assert not offsets.add("/base", stamp(97.0), 100.0)
    assert offsets.add("/base", stamp(97.0), 100.0)
    assert offsets.large == {"/base": -3.0}
    assert not offsets.add("/base", stamp(97.1), 100.0)


def test_a_late_message_is_no_offset() -> None:
    offsets = ClockOffsets()
    for late in (0.0, 5.0, 9.0, 0.2, 7.0):
        offsets.add("/base", stamp(100.0), 100.0 + late)
    assert offsets.large == {}


def test_no_stamp_is_no_offset() -> None:
    offsets = ClockOffsets()
    for _ in range(5):
        offsets.add("/odom", stamp(0.0), 100.0)
    assert offsets.large == {}


def test_a_clock_that_was_set_is_over() -> None:
    offsets = ClockOffsets()
    for _ in range(3):
        offsets.add("/base", stamp(200.0), 100.0)
    assert offsets.add("/base", stamp(100.0), 100.0)
    assert offsets.large == {}


def test_the_alarm_names_who_is_off_and_how_far() -> None:
    clocks = NORMAL._replace(clock_offsets={"/base": -3.2, "/odom": 61.0})
    text = "CLOCKS DIFFER: /odom is 61.0 s ahead, /base is 3.2 s behind: set one of them"
    assert conditions(clocks, NOW)["clocks differ"].startswith(text)
