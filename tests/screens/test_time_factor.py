"""A robot that drives faster than its speed says: a simulation, which says so itself."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from archo_tui.robot.state.graph import Parameter
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.text import line_by_line
from archo_tui.text.goal import goal_line
from archo_tui.text.state import motion_line
from tests.support.clock import NOW
from tests.support.console import console
from tests.support.states import MOTOR, MOVING, NORMAL, plain_text


def simulated(value: object) -> Snapshot:
    scale = Parameter("/motor_controller", "time_scale", "double", value, value)
    return NORMAL._replace(goal=MOVING, motion=MOTOR, parameters=(*NORMAL.parameters, scale))


def test_the_factor_stands_beside_the_speed_and_the_time_left() -> None:
    snapshot = simulated(7.5)
    assert plain_text(motion_line(snapshot, NOW)).endswith("0.00 m/s x 7.5")
    assert plain_text(goal_line(snapshot, NOW, "")).endswith("about 1.5 s left x 7.5")
    assert line_by_line.motion_text(snapshot, NOW).endswith("0.00 m/s x 7.5")
    assert line_by_line.goal_text(snapshot, NOW, "").endswith("about 1.5 s left x 7.5")


@pytest.mark.parametrize(
    ("count", "said"),  # in the 24 cells of a terminal of 80 columns
    [
        (15_420, "15 420 0.00 m/s x 7.5"),
        (12_345_678, "12345678 0.00 m/s x 7.5"),
        (1_234_567_890, "0.00 m/s x 7.5"),
    ],
)
def test_where_room_is_short_the_factor_stays_and_the_count_gives_way(
    count: int, said: str
) -> None:
    snapshot = simulated(7.5)._replace(motion=replace(MOTOR, count=count))
    assert plain_text(motion_line(snapshot, NOW, 24)).strip() == said


@pytest.mark.parametrize("value", [1.0, 1, "fast", float("nan"), -2.0])
def test_nothing_is_said_of_real_time_nor_of_what_is_no_factor(value: object) -> None:
    assert simulated(value).time_factor is None
    assert plain_text(motion_line(simulated(value), NOW)).endswith("0.00 m/s")
    assert plain_text(goal_line(simulated(value), NOW, "")).endswith("about 1.5 s left")


def test_the_factor_is_whole_or_not_beside_the_time_left() -> None:
    whole = plain_text(goal_line(simulated(7.5), NOW, ""))
    for width in range(40, 90):
        said = plain_text(goal_line(simulated(7.5), NOW, "", width))
        assert said.endswith((" x 7.5", " left"))
        assert len(said) <= max(width, len(whole.removesuffix(" x 7.5")))


async def test_archo_says_that_it_drives_faster_until_it_does_not() -> None:
    async with console("-p", "route_length:=100.0") as op:
        await op.press("g", "5", "enter")
        await op.until("0.80 m/s x 7.5")
        await op.until(lambda: re.search(r"about \d+.\d s left x 7.5", op.text))
        await op.press("h")
        await op.until("speed 0.80 m/s x 7.5")
        await op.press("escape")
        await op.app.station.robot.set_parameters("/motor_controller", {"time_scale": 1.0})
        await op.until(lambda: "x 7.5" not in op.text)
