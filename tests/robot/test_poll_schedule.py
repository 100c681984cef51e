"""Things that are asked for again and again, the urgent ones first."""

from __future__ import annotations

from itertools import islice

from archo_tui.robot.poll_schedule import LEAST, PERIOD, PollSchedule


def test_a_few_are_all_due_each_time() -> None:
    schedule: PollSchedule[int] = PollSchedule()
    schedule.set_items({*range(LEAST)})
    for _ in range(3):
        assert sorted(schedule.due()) == [*range(LEAST)]


def test_each_of_many_is_due_within_the_period() -> None:
    schedule: PollSchedule[int] = PollSchedule()
    many = {*range(100 * PERIOD)}
    schedule.set_items(many)
    assert {*schedule.due()} == many  # all are new
    looks = [[*schedule.due()] for _ in range(PERIOD)]
    assert {len(look) for look in looks} == {100}
    assert {thing for look in looks for thing in look} == many


def test_what_there_was_no_time_for_comes_first_the_next_time() -> None:
    schedule: PollSchedule[int] = PollSchedule()
    schedule.set_items({*range(1000)})
    first = [*islice(schedule.due(), 300)]
    second = [*islice(schedule.due(), 700)]
    assert {*first, *second} == {*range(1000)}
    schedule.prioritize([first[0]])
    assert next(schedule.due()) == first[0]


def test_what_has_left_is_not_due_and_what_comes_back_is_urgent() -> None:
    schedule: PollSchedule[int] = PollSchedule()
    schedule.set_items({*range(1000)})
    assert len([*schedule.due()]) == 1000
    schedule.set_items({*range(999)})
    assert 999 not in {thing for _ in range(PERIOD) for thing in schedule.due()}
    schedule.set_items({*range(1000)})
    assert next(schedule.due()) == 999
