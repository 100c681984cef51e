"""The history: samples in, columns and curves out."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest

from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.screen.widgets.history_panel import covered_span, end_marks
from archo_tui.station.history import History, Quantity
from archo_tui.text.plot import curve
from tests.support.states import BATTERY, MOTOR, MOVING, NORMAL


def filled(seconds: int) -> History:
    """The charge is the second's number."""
    history = History()
    for second in range(seconds):
        battery = BATTERY._replace(percentage=float(second), received=float(second))
        history.observe(NORMAL._replace(battery=battery), float(second))
    return history


def greatest(history: History, quantity: Quantity, span: float, count: int, now: float) -> Any:
    ranges = history.ranges(quantity, span, count, now)
    return [None if both is None else both[1] for both in ranges]


def test_each_column_has_the_range_of_its_part_and_an_hour_is_kept() -> None:
    found = filled(100).ranges("charge", 50.0, 5, 99.0)
    assert found == ((50, 59), (60, 69), (70, 79), (80, 89), (90, 99))
    assert None not in filled(20).ranges("charge", 10.0, 40, 19.0)[-36:]
    long = greatest(filled(5000), "charge", 5000.0, 5000, 4999.0)
    assert long.count(None) in range(1300, 1401)
    assert long[-2:] == [4998.0, 4999.0]


def test_a_column_that_is_past_never_changes() -> None:
    history = filled(100)
    before = greatest(history, "charge", 50.0, 5, 95.0)
    history.observe(
        NORMAL._replace(battery=BATTERY._replace(percentage=7.0, received=101.0)), 101.0
    )
    after = greatest(history, "charge", 50.0, 5, 101.0)
    assert after == [*before[1:4], 99.0, 7.0]


def test_what_is_old_or_not_reported_is_a_gap() -> None:
    history = History()
    for second in range(10):
        battery = BATTERY._replace(received=0.0)  # silent from the first second on
        motion = replace(MOTOR, speed=None, received=float(second))
        history.observe(NORMAL._replace(battery=battery, motion=motion), float(second))
    assert greatest(history, "charge", 10.0, 10, 9.0)[-5:] == [None] * 5
    assert greatest(history, "speed", 10.0, 10, 9.0) == [None] * 10


def test_a_drive_between_two_samples_is_in_the_history() -> None:
    history = History()
    for tenth in range(40):
        motion = replace(MOTOR, speed=0.8 if 13 <= tenth < 16 else 0.0, received=tenth / 10)
        history.observe(NORMAL._replace(motion=motion), tenth / 10)
        if tenth % 10 == 0:
            history.observe(NORMAL._replace(motion=motion), tenth / 10)
    assert (0.0, 0.8) in history.ranges("speed", 4.0, 4, 3.9)


def test_goals_that_the_robot_lists_no_longer_are_kept_for_the_hour() -> None:
    history = History()
    for number in range(50):
        newest = [_end(number - back, 60.0 * (number - back)) for back in range(min(number, 20))]
        history.observe(NORMAL._replace(history=tuple(newest)), 60.0 * number)
    assert [goal.number for goal in history.ends(60.0 * 50)] == list(range(49, 0, -1))
    assert [goal.number for goal in history.ends(180.0)] == [3, 2, 1]


def _end(number: int, time: float, phase: Phase = Phase.ARRIVED) -> Goal:
    fields = {"shelf_number": number}
    return MOVING._replace(number=number, fields=fields, phase=phase, time=time)


@pytest.mark.parametrize(
    ("ends", "said"),  # each goal, and the cell in which it ended
    [
        ("5✓10", "          ✓ 5       "),
        ("5✓19", "                   ✓"),
        ("5✓8 6✓10 7✓12 8✓14", "        ✓ ✓ ✓ ✓ 8   "),
        ("5✓8 6✓9 7✓10", "        ✓✓✓ 7       "),
        ("3✗2 4✗7 5✗12", "  ✗ 3  ✗ 4  ✗ 5     "),
        ("5✓8 6✗8 7✓8", "        ✗ 6         "),
        ("5✓-1 6✓1", " ✓ 6                "),
    ],
)
def test_each_end_has_a_mark_and_a_failed_one_goes_before(ends: str, said: str) -> None:
    phases = {"✓": Phase.ARRIVED, "✗": Phase.ABORTED}
    found = [re.split("([✓✗])", one) for one in reversed(ends.split())]
    made = [_end(int(number), int(cell) + 0.5, phases[how]) for number, how, cell in found]
    assert end_marks(made, 20.0, 20.0, 20) == said


def test_the_way_left_is_only_of_a_goal_that_runs() -> None:
    history = History()
    history.observe(NORMAL._replace(goal=MOVING), 1.0)
    history.observe(NORMAL._replace(goal=None), 2.0)
    assert greatest(history, "left", 2.0, 2, 2.0) == [9.0, None]


FLAT = [(9.0, 9.0)] * 4


@pytest.mark.parametrize(
    ("values", "least", "greatest", "rows", "mark", "drawn"),
    [
        ([(0, 0), (0, 0), (3, 3), (3, 3)], 0, 3, 1, None, ["⣀⡏"]),
        ([None, (0.0, 0.0)], 0, 10, 2, None, [" ", "⢀"]),
        ([(8, 8), (8, 8), None, None], 0, 8, 2, 1.0, ["⠉ ", "┄┄"]),
        ([(0, 3), (1, 1)], 0, 3, 1, None, ["⡧"]),  # what each dot stands for
        ([(2, 3), (0, 0)], 0, 3, 1, None, ["⢳"]),
        (FLAT, 0, 9, 3, None, ["⠉⠉", "░░", "░░"]),
        (FLAT, 0, 9, 3, 0.0, ["⠉⠉", "░░", "┄┄"]),
        ([(-9.0, -9.0)] * 2, -9, 9, 4, None, [" ", " ", " ", "⣀"]),
    ],
)
def test_a_curve_joins_its_dots_is_filled_to_zero_and_dashes_a_mark(
    values: Any, least: float, greatest: float, rows: int, mark: float | None, drawn: list[str]
) -> None:
    assert curve(values, least, greatest, rows, mark=mark) == drawn


def test_a_plot_begins_with_the_start_and_grows_to_its_span() -> None:
    for passed, covered in ((0, 20), (19, 20), (21, 30), (400, 450), (599, 600), (5000, 600)):
        assert covered_span(filled(passed + 1), 600.0, float(passed)) == covered, passed
    assert covered_span(filled(300), 60.0, 299.0) == 60.0
    assert covered_span(History(), 600.0, 5.0) == 20.0
