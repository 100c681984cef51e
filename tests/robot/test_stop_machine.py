"""The rules of STOP one by one; which states there are, test_explore.py explores."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

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


# The rules of STOP one by one: the order of turns, late answers, reports of motion.

FAR = frozenset({("/far", frozenset({b"7"}))})
HELD = answered(called(), StopAnswer.AWAITED)


def test_a_machine_to_which_nothing_has_happened_wants_nothing() -> None:
    stop = Stop()
    assert stop.shown == (None, Latch.NONE, "", False, False)
    assert stop.may_start
    assert not any((stop.has_reached_nobody, stop.is_held_by_nobody, stop.is_given_up))
    assert not any((stop.reports, stop.says_stopped, stop.is_held_here))
    assert stop.tick(60.0, ALL)[1] == []
    assert stop.must_be_obeyed(60.0) == 0
    assert not stop.must_follow(1)
    assert stop.is_wanted(1)


def test_the_first_turn_of_all_counts_as_any_other() -> None:
    assert Stop().goal_accepted(1, 5.0).released == 5.0
    assert Stop().release_accepted(1, 5.0, 2).released == 5.0
    stop = Stop().calling(1, 0.0, is_pressed=True).leaving(1, MOTOR)
    assert StopEffect.CANCEL_ALL in todo(stop, 60.0)
    shown = stop.answered_by(Result(StopAnswer.REFUSED), 1, 0.0, 2, MOTOR, MOTOR, ()).open
    assert shown is not None
    assert shown.answer is StopAnswer.REFUSED


# The open STOP.


def test_a_repeat_cancels_nothing_anew_and_a_press_does() -> None:
    stop, _ = called().tick(2.0, ALL)
    assert StopEffect.CANCEL_ALL not in todo(stop.calling(8, 3.0, is_pressed=False), 5.0)
    assert StopEffect.CANCEL_ALL in todo(stop.calling(8, 3.0, is_pressed=True), 5.0)


def test_a_call_that_the_machine_opens_itself_is_as_good_as_a_press() -> None:
    done, _ = called().tick(2.0, ALL)
    opened = done.given_up().calling(8, 3.0, is_pressed=False)
    assert opened.open is not None
    assert StopEffect.CANCEL_ALL in todo(opened.leaving(9, MOTOR), 5.0)
    assert opened.must_follow(7)  # It is not given up, as the one before was.


def test_the_goals_of_others_are_cancelled_by_their_ids_once_all_were() -> None:
    stop, first = called().tick(2.0, ALL)
    assert (StopEffect.CANCEL_ALL, 2) in first
    assert (StopEffect.CANCEL_OTHERS, 2) in stop.tick(2.1, ALL)[1]
    assert StopEffect.CANCEL_OTHERS not in todo(stop.given_up(), 2.1)


def test_a_node_that_got_a_later_call_is_not_confirmed_by_an_earlier() -> None:
    both = called().calling(5, 1.0, is_pressed=False).leaving(6, MOTOR | FAR)
    early = both.answered_by(Result(StopAnswer.AWAITED), 2, 1.0, 7, MOTOR, MOTOR | FAR, ())
    assert early.open is not None
    left = both.answered_by(Result(StopAnswer.AWAITED), 2, 1.0, 7, MOTOR, MOTOR, ())
    assert (left.open, left.latch) == (None, Latch.UNCERTAIN)
    assert left.doubt == "/far has left without an answer"


def test_the_answer_of_the_last_call_is_shown() -> None:
    refused = Result(StopAnswer.REFUSED, "busy")
    silent = Result(StopAnswer.NONE)
    stop = called().calling(5, 1.0, is_pressed=False).leaving(6, MOTOR)

    def shown(*answers: tuple[Result, int]) -> StopAnswer | None:
        after = stop
        for result, turn in answers:
            after = after.answered_by(result, turn, 2.0, 9, MOTOR, MOTOR, ())
        return after.open and after.open.answer

    assert shown((refused, 5), (silent, 2)) is StopAnswer.REFUSED
    assert shown((silent, 5), (refused, 2)) is StopAnswer.REFUSED  # Rather than nothing.
    assert shown((refused, 2), (silent, 5)) is StopAnswer.REFUSED  # It refuses, late.
    unsent = Result(StopAnswer.NOT_SENT)
    assert shown((refused, 2), (unsent, 5)) is StopAnswer.NOT_SENT
    assert shown((unsent, 5), (refused, 2)) is StopAnswer.NOT_SENT
    assert shown((unsent, 5), (refused, 5)) is StopAnswer.NOT_SENT


def test_an_empty_answer_is_to_be_obeyed_and_a_refusal_is_not() -> None:
    empty = answered(called(), StopAnswer.UNCONFIRMED, 1.0)
    assert empty.must_be_obeyed(1.0 + OBEYED) == 2
    assert answered(called(), StopAnswer.REFUSED, 1.0).must_be_obeyed(60.0) == 0


def test_a_stop_that_has_reached_nobody_has_never_left() -> None:
    unsent = Result(StopAnswer.NOT_SENT)
    stop = Stop().calling(2, 0.0, is_pressed=True)
    assert not stop.has_reached_nobody  # It may leave yet.
    never = stop.answered_by(unsent, 2, 0.0, 4, NOBODY, NOBODY, ())
    assert never.has_reached_nobody
    left = never.calling(5, 1.0, is_pressed=False).leaving(5, MOTOR)
    assert not left.has_reached_nobody
    first = stop.leaving(2, MOTOR).answered_by(unsent, 2, 0.0, 4, NOBODY, NOBODY, ())
    assert not first.has_reached_nobody
    behind = HELD.calling(8, 1.0, is_pressed=True)
    assert (
        not behind._replace(last_turn=0)
        .answered_by(unsent, 8, 1.0, 9, NOBODY, NOBODY, ())
        .has_reached_nobody
    )  # The one before holds.


def test_an_answer_to_a_stop_that_is_over_is_not_shown() -> None:
    refused = Result(StopAnswer.REFUSED, "busy")
    later = called().given_up().calling(8, 1.0, is_pressed=True).leaving(9, MOTOR)
    late = later.answered_by(refused, 2, 2.0, 10, MOTOR, MOTOR, ())
    assert (late.open, late.awaited) == (later.open, later.awaited - 1)
    over = called().given_up().answered_by(refused, 2, 2.0, 10, MOTOR, MOTOR, ())
    assert over.open is None
    both = called().calling(5, 1.0, is_pressed=False).leaving(6, MOTOR | FAR).given_up()
    yes = both.answered_by(Result(StopAnswer.AWAITED), 2, 9.0, 10, MOTOR, MOTOR | FAR, ())
    assert yes.latch is Latch.UNCERTAIN


def test_what_ends_a_stop_ends_all_that_followed_it() -> None:
    disobeying = HELD.moved(moving(OBEYED), OBEYED, MOTOR, ())._replace(holders_have_ended=True)
    over = disobeying.goal_accepted(9, 5.0)
    assert not over.is_not_obeyed
    assert not over.holders_have_ended
    assert not over.must_follow(1)
    done, _ = called().tick(2.0, ALL)
    assert StopEffect.CANCEL_OTHERS not in todo(done.goal_accepted(9, 5.0), 6.0)
    # Another console's release of its own STOP ends nothing of ours.
    peers = Stop().stopped_elsewhere("lab", 1, 0.0, MOTOR, ())
    ours, _ = peers.calling(2, 0.0, is_pressed=True).leaving(3, MOTOR).tick(2.0, ALL)
    assert (StopEffect.CANCEL_OTHERS, 2) in ours.released_elsewhere("lab", 4, 3.0).tick(4.0, ALL)[1]
    held = answered(ours, StopAnswer.AWAITED).moved(
        Motion(stopped=True, received=5.0), 5.0, MOTOR, ()
    )
    free = held.moved(Motion(stopped=False, received=6.0), 6.0, MOTOR, ())
    assert StopEffect.CANCEL_OTHERS not in todo(free, 7.0)


def test_a_call_leaves_while_its_stop_is_wanted() -> None:
    assert called().is_wanted(2)
    assert not called().given_up().is_wanted(2)
    released = HELD.release_accepted(7, 1.0, 8)
    assert not released.is_wanted(6)
    assert released.is_wanted(7)


# What was sent before a STOP, and is answered behind it.


def test_a_goal_from_before_a_stop_changes_nothing() -> None:
    for stop in (called(), HELD):
        assert stop.goal_accepted(1, 9.0) == stop.goal_accepted(3, 9.0) == stop
        after = stop.goal_accepted(4, 9.0)
        assert (after.open, after.latch, after.released) == (None, Latch.NONE, 9.0)


def test_a_release_counts_by_its_turn() -> None:
    early = HELD.release_accepted(3, 9.0, 10)
    assert (early.latch, early.undone) == (Latch.UNCERTAIN, 9.0)
    assert early.doubt == "a release from before it was answered behind it"
    assert early.must_follow(3)
    assert HELD.release_accepted(4, 9.0, 10).latch is Latch.NONE
    peers = Stop().stopped_elsewhere("lab", 5, 0.0, MOTOR, ())
    assert peers.release_accepted(5, 9.0, 10).latch is Latch.UNCERTAIN
    assert peers.goal_accepted(5, 9.0) == peers
    assert peers.release_accepted(6, 9.0, 10).latch is Latch.NONE


def test_what_must_be_followed_by_another_stop() -> None:
    again = called()._replace(last_turn=0)
    assert again.must_follow(1)
    assert not again.must_follow(2)  # It was opened in this very turn.
    assert HELD.must_follow(3)
    assert not HELD.must_follow(4)
    assert not called().given_up().must_follow(3)


def test_a_late_yes_to_a_stop_that_is_past_holds() -> None:
    def late(stop: Stop, turn: int) -> Latch:
        yes = Result(StopAnswer.AWAITED)
        return stop.answered_by(yes, turn, 20.0, 30, MOTOR, MOTOR, (), is_late=True).latch

    released = called().release_accepted(7, 1.0, 8)
    assert late(released, 6) is Latch.UNCERTAIN
    assert late(released, 7) is Latch.HELD
    assert late(called().given_up(), 2) is Latch.HELD


def test_a_yes_to_a_held_stop_only_says_when_it_is_to_be_obeyed() -> None:
    again = HELD.answered_by(Result(StopAnswer.AWAITED), 5, 9.0, 30, FAR, MOTOR, ())
    assert (again.held, again.holders) == (HELD.held, HELD.holders)
    assert again.must_be_obeyed(9.0 + OBEYED) == 5


def test_a_later_yes_holds_anew_while_a_stop_is_open() -> None:
    open_again = HELD.calling(6, 4.0, is_pressed=True).leaving(7, FAR)
    held = open_again.answered_by(Result(StopAnswer.AWAITED), 6, 5.0, 8, FAR, FAR, ())
    assert (held.held, held.holders) == (5.0, FAR)


# Who holds it.


def test_a_node_that_carried_it_out_before_it_spun_holds_it_too() -> None:
    early = called().carried_out_early("/motor")
    held = early.answered_by(Result(StopAnswer.AWAITED), 2, 0.0, 4, AGAIN, MOTOR, ())
    assert held.latch is Latch.HELD
    gone = held.served_by(NOBODY, (), 1.0)
    assert gone.latch is Latch.UNCERTAIN
    # In the name of a later STOP it must be called as any other.
    told = early._replace(open=None).stopped_elsewhere("lab", 9, 5.0, AGAIN, ())
    assert told.served_by(MOTOR, (), 6.0).latch is Latch.UNCERTAIN


def test_it_is_held_here_as_long_as_only_nodes_of_this_process_serve_it() -> None:
    here = ("/motor",)
    yes = Result(StopAnswer.AWAITED)
    held = called().answered_by(yes, 2, 0.0, 4, MOTOR, MOTOR, here)
    assert held.is_held_here
    reported = held.served_by(AGAIN, (), 1.0).moved(Motion(stopped=True), 9.0, MOTOR, ())
    assert not reported.is_held_here
    again = held._replace(state=Stop().state).stopped_elsewhere("lab", 9, 5.0, MOTOR, ())
    assert again.is_held_here  # Told once more, of the same nodes.
    assert not called().answered_by(yes, 2, 0.0, 4, FAR, FAR, here).is_held_here
    assert not Stop().stopped_elsewhere("lab", 9, 5.0, NOBODY, here).is_held_here


def test_holding_anew_forgets_what_had_ended_and_was_given_up() -> None:
    ended = HELD._replace(holders_have_ended=True, is_given_up=True)
    assert (
        not ended._replace(state=Stop().state)
        .stopped_elsewhere("lab", 9, 5.0, MOTOR, ())
        .holders_have_ended
    )
    told = Stop(is_given_up=True).stopped_elsewhere("lab", 9, 5.0, MOTOR, ())
    assert told.is_given_up  # Ours is, whatever another console's does.
    late = (
        called()
        .given_up()
        .answered_by(Result(StopAnswer.AWAITED), 2, 9.0, 10, MOTOR, MOTOR, (), is_late=True)
    )
    assert not late.is_given_up


def test_only_the_console_that_stopped_it_undoes_its_own_stop() -> None:
    peers = Stop().stopped_elsewhere("lab", 5, 0.0, MOTOR, ())
    assert peers.released_elsewhere("lab", 6, 9.0).latch is Latch.NONE
    other = peers.released_elsewhere("desk", 6, 9.0)
    assert (other.latch, other.doubt) == (Latch.UNCERTAIN, "console desk released it")
    doubted = peers.released_elsewhere("desk", 6, 9.0)
    assert doubted.released_elsewhere("lab", 7, 10.0).latch is Latch.UNCERTAIN


def test_another_consoles_stop_of_a_robot_that_is_held_changes_not_who_holds_it() -> None:
    told = HELD.stopped_elsewhere("lab", 5, 3.0, FAR, ())
    assert (told.latch, told.holders, told.peer) == (Latch.HELD, MOTOR, "")
    assert told.must_be_obeyed(3.0 + OBEYED) == 5


def test_another_consoles_stop_is_left_to_a_robot_that_reports_it() -> None:
    reporting = Stop(reports=True)
    told = reporting.stopped_elsewhere("lab", 5, 3.0, MOTOR, ())
    assert told.latch is Latch.NONE
    assert told.must_be_obeyed(3.0 + OBEYED) == 5


# Motion.


def test_a_report_closes_a_stop_that_has_left() -> None:
    says = Motion(stopped=True, received=0.0)
    assert called().moved(says, 1.0, MOTOR, ()).open is None
    unsent = Stop().calling(2, 0.0, is_pressed=True)
    assert unsent.moved(says, 1.0, MOTOR, ()).open is not None
    assert unsent.leaving(2, MOTOR).moved(says, 1.0, MOTOR, ()).open is None


def test_a_robot_that_stands_or_says_that_it_was_released_obeys() -> None:
    disobeys = HELD.moved(moving(OBEYED), OBEYED, MOTOR, ())
    assert disobeys.is_not_obeyed
    stands = Motion(moving=False, received=2.0)
    assert not disobeys.moved(stands, 2.0, MOTOR, ()).is_not_obeyed
    says = HELD.moved(moving(5.0, stopped=True), 5.0, MOTOR, ())
    assert not says.moved(moving(9.0, stopped=False), 9.0, MOTOR, ()).is_not_obeyed


def test_a_robot_that_was_stopped_by_something_else_has_a_second_to_stand() -> None:
    says = Stop().moved(moving(5.0, stopped=True), 5.0, MOTOR, ())
    assert not says.is_not_obeyed
    assert says.moved(moving(5.9, stopped=True), 5.9, MOTOR, ()).is_not_obeyed is False
    assert says.moved(moving(6.0, stopped=True), 6.0, MOTOR, ()).is_not_obeyed


def test_a_stop_is_to_be_obeyed_from_when_it_was_asked() -> None:
    stop = answered(called(4.0), StopAnswer.AWAITED, 4.8)
    assert not stop.moved(moving(4.9), 4.9, MOTOR, ()).is_not_obeyed
    assert stop.moved(moving(5.0), 5.0, MOTOR, ()).is_not_obeyed


def test_a_robot_that_stood_and_moves_for_a_second_makes_it_uncertain() -> None:
    stood = HELD.moved(Motion(moving=False, received=5.0), 5.0, MOTOR, ())
    begun = stood.moved(moving(6.0), 6.0, MOTOR, ())
    assert begun.latch is Latch.HELD
    assert begun.moved(moving(6.9), 6.9, MOTOR, ()).latch is Latch.HELD
    moved = begun.moved(moving(7.0), 7.0, MOTOR, ())
    assert (moved.latch, moved.doubt) == (Latch.UNCERTAIN, "the robot moves")
    # What is known to disobey is told as that; what reports its stop is believed.
    disobeying = HELD.moved(moving(5.0), 5.0, MOTOR, ()).moved(moving(7.0), 7.0, MOTOR, ())
    assert (disobeying.latch, disobeying.is_not_obeyed) == (Latch.HELD, True)
    reporting = begun.moved(moving(7.0, stopped=False), 7.0, MOTOR, ())
    assert reporting.latch is Latch.HELD
    # A pause, or a time that is not known, begins it anew.
    paused = begun.moved(Motion(moving=False, received=6.5), 6.5, MOTOR, ())
    assert paused.moved(moving(7.0), 7.0, MOTOR, ()).latch is Latch.HELD
    unknown = begun.moved(Motion(moving=True), 6.5, MOTOR, ())
    assert unknown.moved(moving(7.2), 7.2, MOTOR, ()).latch is Latch.HELD


# What follows.


def test_the_later_stop_is_the_one_to_be_obeyed() -> None:
    stop = HELD.answered_by(Result(StopAnswer.AWAITED), 5, 9.0, 30, MOTOR, MOTOR, ())
    earlier = stop.answered_by(Result(StopAnswer.AWAITED), 2, 20.0, 31, MOTOR, MOTOR, ())
    assert earlier.must_be_obeyed(9.0 + OBEYED) == 5
    same = stop.answered_by(Result(StopAnswer.AWAITED), 5, 20.0, 31, MOTOR, MOTOR, ())
    assert same.must_be_obeyed(9.0 + OBEYED) == 0
    assert same.must_be_obeyed(20.0 + OBEYED) == 5


def test_an_answer_does_not_put_off_what_is_cancelled() -> None:
    stop = answered(called(), StopAnswer.UNCONFIRMED, 5.0)
    assert (StopEffect.CANCEL_OWN, 2) in stop.tick(5.0, ALL)[1]


def test_goals_from_before_a_later_stop_are_due_with_those_of_the_one_before() -> None:
    stop = called()
    both = stop._replace(open=None).calling(8, 0.1, is_pressed=True)
    assert (StopEffect.CANCEL_OWN, 8) in both.tick(CANCEL_AFTER, ALL)[1]
    later = stop._replace(open=None).calling(8, 5.0, is_pressed=True)
    assert later.tick(5.1, ALL)[1] == []
    assert (StopEffect.CANCEL_OWN, 8) in later.tick(5.0 + CANCEL_AFTER, ALL)[1]
    at_once = stop._replace(open=None).calling(8, CANCEL_AFTER, is_pressed=True)
    assert at_once.tick(CANCEL_AFTER, ALL)[1] == []


# A STOP is held by nobody only once every node that can hold it has ended in this process.

HERE, ELSEWHERE, NAMESAKE = b"1", b"2", b"3"  # The ids of nodes.


class Nodes:
    """A STOP that holds, and the nodes that serve it.

    Attributes:
        stop: The state of the machine.
        unended: The nodes of this process whose code may still run.
    """

    def __init__(self, **served: bytes | set[bytes]) -> None:
        self.unended = ["motor"]
        self.stop = Stop()
        self._turns = itertools.count(1)
        self.confirm(**served)

    def confirm(self, **served: bytes | set[bytes]) -> None:
        """All nodes that serve STOP say yes to a call."""
        turn, servers = next(self._turns), _servers(served)
        called = self.stop.calling(turn, 0.0, is_pressed=True).leaving(next(self._turns), servers)
        yes = Result(StopAnswer.AWAITED)
        self.stop = called.answered_by(
            yes, turn, 0.0, next(self._turns), servers, servers, self.unended
        )

    def move(self, motion: Motion, **served: bytes | set[bytes]) -> None:
        self.stop = self.stop.moved(motion, 9.0, _servers(served), self.unended)

    def look(self, **served: bytes | set[bytes]) -> bool:
        """Return whether nobody holds the STOP once these nodes serve it."""
        self.stop = self.stop.served_by(_servers(served), self.unended, 9.0)
        return self.stop.is_held_by_nobody


def _servers(served: Mapping[str, bytes | set[bytes]]) -> Servers:
    return frozenset(
        (node, frozenset(ids if isinstance(ids, set) else {ids})) for node, ids in served.items()
    )


def test_one_whose_node_ran_here_and_has_ended_is_held_by_nobody() -> None:
    nodes = Nodes(motor=HERE)
    nodes.unended = []
    assert not nodes.look(motor=HERE)  # It is still on the graph.
    assert nodes.look()


def test_a_last_report_of_nodes_that_have_ended_does_not_put_them_elsewhere() -> None:
    nodes = Nodes(motor=HERE)
    nodes.unended = []
    assert nodes.look()
    nodes.move(Motion(stopped=True))
    assert nodes.look()


def test_one_whose_node_has_ended_and_that_was_released_elsewhere_is_uncertain() -> None:
    nodes = Nodes(motor=HERE)
    nodes.move(Motion(stopped=True))  # A robot that reports its stops.
    nodes.unended = []
    assert nodes.look()
    nodes.stop = nodes.stop.released_elsewhere("other", 9, 9.0)
    assert nodes.stop.latch is Latch.UNCERTAIN
    assert nodes.look()


def test_what_moves_behind_a_release_is_not_said_to_disobey() -> None:
    nodes = Nodes(motor=HERE)
    nodes.move(Motion(moving=True, received=5.0))
    assert nodes.stop.is_not_obeyed
    nodes.stop = nodes.stop.release_accepted(9, 9.0, 10)
    assert not nodes.stop.is_not_obeyed


def test_one_whose_node_has_left_but_is_not_ended_is_held() -> None:
    nodes = Nodes(motor=HERE)
    assert not nodes.look()  # Its program is suspended: it returns, and holds the STOP.
    assert not nodes.look(motor=HERE)
    nodes.unended = []
    assert nodes.look()


def test_one_of_an_ended_nodes_namesake_elsewhere_is_held() -> None:
    nodes = Nodes(motor=HERE)
    nodes.unended = []
    nodes.confirm(motor=ELSEWHERE)
    assert not nodes.look()


def test_one_of_two_nodes_of_one_name_is_held() -> None:
    nodes = Nodes(motor={HERE, NAMESAKE})
    nodes.unended = []
    assert not nodes.look()


def test_one_that_a_node_elsewhere_may_have_got_since_is_held() -> None:
    nodes = Nodes(motor=HERE)
    assert not nodes.look(motor=HERE, other=ELSEWHERE)
    nodes.unended = []
    assert not nodes.look(other=ELSEWHERE)
    assert not nodes.look()


def test_one_of_a_node_started_anew_here_is_held_by_nobody_at_its_end() -> None:
    nodes = Nodes(motor=HERE)
    assert not nodes.look(motor=NAMESAKE)
    nodes.stop = nodes.stop.carried_out_early("motor")
    assert not nodes.look(motor=NAMESAKE)
    nodes.unended = []
    assert nodes.look()
