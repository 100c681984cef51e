"""Things that are asked for again and again, the urgent ones first."""

from __future__ import annotations

from itertools import islice

import pytest

from archo_tui.robot.graph.resources import LEAST, PERIOD, PollSchedule

pytestmark = pytest.mark.pure


def test_a_few_are_all_due_each_time() -> None:
    schedule: PollSchedule[int] = PollSchedule()
    schedule.set_items({*range(LEAST)})
    for _ in range(3):
        assert sorted(schedule.take_due()) == [*range(LEAST)]


def test_each_of_many_is_due_within_the_period() -> None:
    schedule: PollSchedule[int] = PollSchedule()
    many = {*range(100 * PERIOD)}
    schedule.set_items(many)
    assert {*schedule.take_due()} == many  # all are new
    looks = [[*schedule.take_due()] for _ in range(PERIOD)]
    assert {len(look) for look in looks} == {100}
    assert {thing for look in looks for thing in look} == many


def test_what_there_was_no_time_for_comes_first_the_next_time() -> None:
    schedule: PollSchedule[int] = PollSchedule()
    schedule.set_items({*range(1000)})
    first = [*islice(schedule.take_due(), 300)]
    second = [*islice(schedule.take_due(), 700)]
    assert {*first, *second} == {*range(1000)}
    schedule.prioritize([first[0]])
    assert next(schedule.take_due()) == first[0]


def test_what_has_left_is_not_due_and_what_comes_back_is_urgent() -> None:
    schedule: PollSchedule[int] = PollSchedule()
    schedule.set_items({*range(1000)})
    assert len([*schedule.take_due()]) == 1000
    schedule.set_items({*range(999)})
    assert 999 not in {thing for _ in range(PERIOD) for thing in schedule.take_due()}
    schedule.set_items({*range(1000)})
    assert next(schedule.take_due()) == 999
