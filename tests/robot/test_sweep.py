"""Things that are asked for again and again, the urgent ones first."""

from __future__ import annotations

from itertools import islice

from archo_tui.robot.sweep import LEAST, PERIOD, Sweep


def test_a_few_are_all_due_each_time() -> None:
    sweep: Sweep[int] = Sweep()
    sweep.follow({*range(LEAST)})
    for _ in range(3):
        assert sorted(sweep.due()) == [*range(LEAST)]


def test_each_of_many_is_due_within_the_period() -> None:
    sweep: Sweep[int] = Sweep()
    many = {*range(100 * PERIOD)}
    sweep.follow(many)
    assert {*sweep.due()} == many  # all are new
    looks = [[*sweep.due()] for _ in range(PERIOD)]
    assert {len(look) for look in looks} == {100}
    assert {thing for look in looks for thing in look} == many


def test_what_there_was_no_time_for_comes_first_the_next_time() -> None:
    sweep: Sweep[int] = Sweep()
    sweep.follow({*range(1000)})
    first = [*islice(sweep.due(), 300)]
    second = [*islice(sweep.due(), 700)]
    assert {*first, *second} == {*range(1000)}
    sweep.hurry([first[0]])
    assert next(sweep.due()) == first[0]


def test_what_has_left_is_not_due_and_what_comes_back_is_urgent() -> None:
    sweep: Sweep[int] = Sweep()
    sweep.follow({*range(1000)})
    assert len([*sweep.due()]) == 1000
    sweep.follow({*range(999)})
    assert 999 not in {thing for _ in range(PERIOD) for thing in sweep.due()}
    sweep.follow({*range(1000)})
    assert next(sweep.due()) == 999
