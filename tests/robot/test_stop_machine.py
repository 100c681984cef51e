"""The times of STOP's rules, each at its edge; which states there are, test_explore.py explores."""

from __future__ import annotations

import pytest

from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Latch, StopAnswer
from archo_tui.robot.stop.machine import (
    CANCEL_AFTER,
    CANCEL_OTHERS_AFTER,
    NOBODY,
    OBEYED,
    REPEAT_AFTER,
    SETTLED,
    Facts,
    Result,
    Servers,
    Stop,
    StopEffect,
)

pytestmark = pytest.mark.pure

MOTOR: Servers = frozenset({("/motor", frozenset({b"1"}))})
AGAIN: Servers = frozenset({("/motor", frozenset({b"2"}))})
ALL = Facts(moves=True, is_heard=True, is_offered=True)
JUST_BEFORE = 0.01


def called(now: float = 0.0) -> Stop:
    """A STOP that left at this time, in turn 2."""
    return Stop().calling(2, now, is_pressed=True).leaving(3, MOTOR)


def answered(stop: Stop, answer: StopAnswer, now: float = 0.0) -> Stop:
    return stop.answered_by(Result(answer), 2, now, 4, MOTOR, MOTOR, ())


def todo(stop: Stop, now: float, facts: Facts = ALL) -> set[StopEffect]:
    return {deed[0] for deed in stop.tick(now, facts)[1]}


def at_edge(stop: Stop, what: StopEffect, after: float) -> None:
    assert what not in todo(stop, after - JUST_BEFORE)
    assert what in todo(stop, after)


def test_the_times_are_those_that_the_page_promises() -> None:
    times = (CANCEL_AFTER, CANCEL_OTHERS_AFTER, REPEAT_AFTER, OBEYED, SETTLED)
    assert times == (0.3, 1.0, 1.0, 1.0, 1.0)


def test_goals_from_here_and_then_those_of_others_are_cancelled() -> None:
    at_edge(called(), StopEffect.CANCEL_OWN, CANCEL_AFTER)
    at_edge(called(), StopEffect.CANCEL_ALL, CANCEL_OTHERS_AFTER)
    still = ALL._replace(moves=False)
    assert StopEffect.CANCEL_ALL not in todo(called(), 10.0, still)


@pytest.mark.parametrize("answer", [StopAnswer.REFUSED, StopAnswer.NONE])
def test_a_stop_that_got_no_yes_is_due_again_while_the_robot_is_heard(answer: StopAnswer) -> None:
    stop = answered(called(), answer, 5.0)
    at_edge(stop, StopEffect.SEND, 5.0 + REPEAT_AFTER)
    assert StopEffect.SEND not in todo(stop, 60.0, ALL._replace(is_heard=False))
    assert StopEffect.SEND in todo(stop, 60.0, ALL._replace(is_offered=False))


def test_a_stop_that_was_not_sent_is_due_once_a_node_offers_it() -> None:
    stop = answered(Stop().calling(2, 0.0, is_pressed=True), StopAnswer.NOT_SENT)
    assert StopEffect.SEND in todo(stop, REPEAT_AFTER, ALL._replace(is_heard=False))
    assert StopEffect.SEND not in todo(stop, 60.0, ALL._replace(is_offered=False))


def test_a_stop_that_cannot_say_yes_is_sent_again_only_while_something_moves() -> None:
    stop = answered(called(), StopAnswer.UNCONFIRMED)
    assert StopEffect.SEND in todo(stop, REPEAT_AFTER)
    assert StopEffect.SEND not in todo(stop, 60.0, ALL._replace(moves=False))


def moving(received: float, *, stopped: bool | None = None) -> Motion:
    return Motion(moving=True, stopped=stopped, received=received)


def test_a_robot_that_moves_for_a_second_behind_a_stop_has_not_obeyed_it() -> None:
    held = answered(called(), StopAnswer.AWAITED)
    assert held.latch is Latch.HELD
    early = held.moved(moving(OBEYED - JUST_BEFORE), OBEYED - JUST_BEFORE, MOTOR, ())
    assert not early.is_not_obeyed
    assert held.moved(moving(OBEYED), OBEYED, MOTOR, ()).is_not_obeyed
    assert held.must_be_obeyed(OBEYED - JUST_BEFORE) == 0
    assert held.must_be_obeyed(OBEYED) == 2


def test_a_report_just_after_another_node_came_may_be_of_the_one_before() -> None:
    doubted = answered(called(), StopAnswer.AWAITED).served_by(AGAIN, (), 10.0)
    assert doubted.latch is Latch.UNCERTAIN
    says = Motion(stopped=True, received=0.0)
    early = doubted.moved(says, 10.0 + SETTLED - JUST_BEFORE, AGAIN, ())
    assert early.latch is Latch.UNCERTAIN
    assert doubted.moved(says, 10.0 + SETTLED, AGAIN, ()).latch is Latch.HELD


def test_another_consoles_stop_is_not_certain_just_after_a_release() -> None:
    released = Stop().release_accepted(5, 10.0, 6)
    early = released.stopped_elsewhere("lab", 7, 10.0 + SETTLED - JUST_BEFORE, MOTOR, ())
    assert early.latch is Latch.UNCERTAIN
    later = released.stopped_elsewhere("lab", 7, 10.0 + SETTLED, MOTOR, ())
    assert later.latch is Latch.HELD


def test_another_consoles_release_that_is_told_late_does_not_undo_the_stop_behind_it() -> None:
    held = answered(called(), StopAnswer.AWAITED)
    reported = held.moved(Motion(stopped=True, received=0.0), 5.0, MOTOR, ())
    told = reported.released_elsewhere("lab", 9, 6.0)
    assert (told.latch, told.may_start) == (Latch.HELD, False)
    released = told.moved(Motion(stopped=False, received=0.0), 7.0, MOTOR, ())
    assert (released.latch, released.may_start) == (Latch.NONE, True)
    # Without such a report nobody knows which was last.
    assert held.released_elsewhere("lab", 9, 6.0).latch is Latch.UNCERTAIN


def test_nobody_that_serves_it_is_told_as_not_sent() -> None:
    stop = Stop().calling(2, 0.0, is_pressed=True)
    unsent = stop.answered_by(Result(StopAnswer.NOT_SENT), 2, 0.0, 4, NOBODY, NOBODY, ())
    assert unsent.has_reached_nobody
    assert not unsent.may_start
    assert unsent.given_up().may_start


def test_who_serves_it_is_asked_for_only_when_a_report_changes_something() -> None:
    held = answered(called(), StopAnswer.AWAITED)
    says = held.moved(Motion(stopped=True, received=0.0), 5.0, MOTOR, ())
    for stop, stopped, needs in (
        (says, False, True),
        (says, True, False),
        (held, False, False),
        (Stop(), True, True),
        (Stop(), False, False),
    ):
        assert stop.needs_servers(Motion(stopped=stopped)) is needs
