"""The rules of STOP one by one; which states there are, test_explore.py explores."""

from __future__ import annotations

from typing import Any

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
    State,
    Stop,
    StopEffect,
)

pytestmark = pytest.mark.pure

MOTOR: Servers = frozenset({("/motor", frozenset({b"1"}))})
AGAIN: Servers = frozenset({("/motor", frozenset({b"2"}))})
FAR: Servers = frozenset({("/far", frozenset({b"7"}))})
ALL = Facts(moves=True, is_heard=True, is_offered=True)
JUST_BEFORE = 0.01
YES, NO, NOTHING = StopAnswer.AWAITED, StopAnswer.REFUSED, StopAnswer.NONE
UNCLEAR, NOT_SENT = StopAnswer.UNCONFIRMED, StopAnswer.NOT_SENT


def pressed(turn: int = 2, now: float = 0.0, stop: Stop = Stop()) -> Stop:  # noqa: B008 - immutable
    return stop.calling(turn, now, is_pressed=True)


def repeated(stop: Stop, turn: int, now: float) -> Stop:
    return stop.calling(turn, now, is_pressed=False)


def called(now: float = 0.0) -> Stop:
    """A STOP that left at this time, in turn 2."""
    return pressed(now=now).leaving(3, MOTOR)


def answered(
    stop: Stop,
    answer: StopAnswer = YES,
    now: float = 0.0,
    *,
    turn: int = 2,
    asked: Servers = MOTOR,
    servers: Servers = MOTOR,
    here: Any = (),
    is_late: bool = False,
) -> Stop:
    return stop.answered_by(Result(answer), turn, now, 30, asked, servers, here, is_late=is_late)


HELD = answered(called())
PEERS = Stop().stopped_elsewhere("lab", 5, 0.0, MOTOR, ())


def reported(stop: Stop, now: float, *, moving: Any = None, stopped: Any = None) -> Stop:
    return stop.moved(Motion(moving=moving, stopped=stopped, received=now), now, MOTOR, ())


def todo(stop: Stop, now: float, facts: Facts = ALL) -> set[StopEffect]:
    return {deed[0] for deed in stop.tick(now, facts)[1]}


def at_edge(stop: Stop, what: StopEffect, after: float) -> None:
    assert what not in todo(stop, after - JUST_BEFORE)
    assert what in todo(stop, after)


def test_the_times_are_those_that_the_page_promises() -> None:
    times = (CANCEL_AFTER, CANCEL_OTHERS_AFTER, REPEAT_AFTER, OBEYED, SETTLED)
    assert times == (0.3, 1.0, 1.0, 1.0, 1.0)


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
    stop = pressed(turn=1).leaving(1, MOTOR)
    assert StopEffect.CANCEL_ALL in todo(stop, 60.0)
    shown = answered(stop, NO, turn=1).open
    assert shown is not None
    assert shown.answer is NO


# The open STOP.


def test_goals_from_here_and_then_those_of_others_are_cancelled() -> None:
    at_edge(called(), StopEffect.CANCEL_OWN, CANCEL_AFTER)
    at_edge(called(), StopEffect.CANCEL_ALL, CANCEL_OTHERS_AFTER)
    assert StopEffect.CANCEL_ALL not in todo(called(), 10.0, ALL._replace(moves=False))


@pytest.mark.parametrize("answer", [NO, NOTHING])
def test_a_stop_that_got_no_yes_is_due_again_while_the_robot_is_heard(answer: StopAnswer) -> None:
    stop = answered(called(), answer, 5.0)
    at_edge(stop, StopEffect.SEND, 5.0 + REPEAT_AFTER)
    assert StopEffect.SEND not in todo(stop, 60.0, ALL._replace(is_heard=False))
    assert StopEffect.SEND in todo(stop, 60.0, ALL._replace(is_offered=False))


def test_a_stop_that_was_not_sent_is_due_once_a_node_offers_it() -> None:
    stop = answered(pressed(), NOT_SENT)
    assert StopEffect.SEND in todo(stop, REPEAT_AFTER, ALL._replace(is_heard=False))
    assert StopEffect.SEND not in todo(stop, 60.0, ALL._replace(is_offered=False))


def test_a_stop_that_cannot_say_yes_is_sent_again_only_while_something_moves() -> None:
    stop = answered(called(), UNCLEAR)
    assert StopEffect.SEND in todo(stop, REPEAT_AFTER)
    assert StopEffect.SEND not in todo(stop, 60.0, ALL._replace(moves=False))


def test_a_call_that_the_machine_opens_itself_is_as_good_as_a_press() -> None:
    done, _ = called().tick(2.0, ALL)
    opened = repeated(done.given_up(), 8, 3.0)
    assert opened.open is not None
    assert StopEffect.CANCEL_ALL in todo(opened.leaving(9, MOTOR), 5.0)
    assert opened.must_follow(7)  # It is not given up, as the one before was.


def test_a_node_that_got_a_later_call_is_not_confirmed_by_an_earlier() -> None:
    both = repeated(called(), 5, 1.0).leaving(6, MOTOR | FAR)
    assert answered(both, servers=MOTOR | FAR).open is not None
    left = answered(both)
    assert (left.open, left.latch) == (None, Latch.UNCERTAIN)
    assert left.doubt == "/far has left without an answer"


@pytest.mark.parametrize(
    ("answers", "shown"),
    [
        (((NO, 5), (NOTHING, 2)), NO),
        (((NOTHING, 5), (NO, 2)), NO),  # Rather than nothing.
        (((NO, 2), (NOTHING, 5)), NO),  # It refuses, late.
        (((NO, 2), (NOT_SENT, 5)), NOT_SENT),
        (((NOT_SENT, 5), (NO, 2)), NOT_SENT),
        (((NOT_SENT, 5), (NO, 5)), NOT_SENT),
    ],
)
def test_the_answer_of_the_last_call_is_shown(answers: Any, shown: StopAnswer) -> None:
    stop = repeated(called(), 5, 1.0).leaving(6, MOTOR)
    for answer, turn in answers:
        stop = answered(stop, answer, 2.0, turn=turn)
    assert stop.open is not None
    assert stop.open.answer is shown


def test_an_empty_answer_is_to_be_obeyed_and_a_refusal_is_not() -> None:
    assert answered(called(), UNCLEAR, 1.0).must_be_obeyed(1.0 + OBEYED) == 2
    assert answered(called(), NO, 1.0).must_be_obeyed(60.0) == 0


def test_a_stop_that_has_reached_nobody_has_never_left() -> None:
    assert not pressed().has_reached_nobody  # It may leave yet.
    never = answered(pressed(), NOT_SENT, asked=NOBODY, servers=NOBODY)
    assert never.has_reached_nobody
    assert not never.may_start
    assert never.given_up().may_start
    assert not repeated(never, 5, 1.0).leaving(5, MOTOR).has_reached_nobody
    assert not answered(pressed().leaving(2, MOTOR), NOT_SENT).has_reached_nobody
    behind = pressed(8, 1.0, HELD)._replace(last_turn=0)
    unsent = answered(behind, NOT_SENT, 1.0, turn=8, asked=NOBODY, servers=NOBODY)
    assert not unsent.has_reached_nobody  # The one before holds.


def test_what_ends_a_stop_ends_all_that_followed_it() -> None:
    disobeying = reported(HELD, OBEYED, moving=True)._replace(holders_have_ended=True)
    over = disobeying.goal_accepted(9, 5.0)
    assert not any((over.is_not_obeyed, over.holders_have_ended, over.must_follow(1)))
    done, _ = called().tick(2.0, ALL)
    assert StopEffect.CANCEL_OTHERS not in todo(done.goal_accepted(9, 5.0), 6.0)
    # Another console's release of its own STOP ends nothing of ours.
    peers = Stop().stopped_elsewhere("lab", 1, 0.0, MOTOR, ())
    ours, _ = pressed(stop=peers).leaving(3, MOTOR).tick(2.0, ALL)
    assert (StopEffect.CANCEL_OTHERS, 2) in ours.released_elsewhere("lab", 4, 3.0).tick(4.0, ALL)[1]
    free = reported(reported(answered(ours), 5.0, stopped=True), 6.0, stopped=False)
    assert StopEffect.CANCEL_OTHERS not in todo(free, 7.0)


def test_a_call_leaves_while_its_stop_is_wanted() -> None:
    assert called().is_wanted(2)
    assert not called().given_up().is_wanted(2)
    released = HELD.release_accepted(7, 1.0, 8)
    assert not released.is_wanted(6)
    assert released.is_wanted(7)


# What was sent before a STOP, and is answered behind it.


def test_a_release_counts_by_its_turn() -> None:
    early = HELD.release_accepted(3, 9.0, 10)
    assert (early.latch, early.undone) == (Latch.UNCERTAIN, 9.0)
    assert early.doubt == "a release from before it was answered behind it"
    assert early.must_follow(3)
    assert HELD.release_accepted(4, 9.0, 10).latch is Latch.NONE
    assert PEERS.release_accepted(5, 9.0, 10).latch is Latch.UNCERTAIN
    assert PEERS.goal_accepted(5, 9.0) == PEERS
    assert PEERS.release_accepted(6, 9.0, 10).latch is Latch.NONE


def test_what_must_be_followed_by_another_stop() -> None:
    again = called()._replace(last_turn=0)
    assert again.must_follow(1)
    assert not again.must_follow(2)  # It was opened in this very turn.
    assert HELD.must_follow(3)
    assert not HELD.must_follow(4)
    assert not called().given_up().must_follow(3)


def test_a_late_yes_to_a_stop_that_is_past_holds() -> None:
    released = called().release_accepted(7, 1.0, 8)
    for stop, turn, latch in (
        (released, 6, Latch.UNCERTAIN),
        (released, 7, Latch.HELD),
        (called().given_up(), 2, Latch.HELD),
    ):
        assert answered(stop, now=20.0, turn=turn, is_late=True).latch is latch


# Who holds it.


def test_a_node_that_carried_it_out_before_it_spun_holds_it_too() -> None:
    early = called().carried_out_early("/motor")
    held = answered(early, asked=AGAIN)
    assert held.latch is Latch.HELD
    assert held.served_by(NOBODY, (), 1.0).latch is Latch.UNCERTAIN
    # In the name of a later STOP it must be called as any other.
    told = early._replace(open=None).stopped_elsewhere("lab", 9, 5.0, AGAIN, ())
    assert told.served_by(MOTOR, (), 6.0).latch is Latch.UNCERTAIN


def test_holding_anew_forgets_what_had_ended_and_was_given_up() -> None:
    ended = HELD._replace(holders_have_ended=True, state=State.NONE)
    assert not ended.stopped_elsewhere("lab", 9, 5.0, MOTOR, ()).holders_have_ended
    told = Stop(is_given_up=True).stopped_elsewhere("lab", 9, 5.0, MOTOR, ())
    assert told.is_given_up  # Ours is, whatever another console's does.
    assert not answered(called().given_up(), now=9.0, is_late=True).is_given_up


# What another console reports.


def test_only_the_console_that_stopped_it_undoes_its_own_stop() -> None:
    assert PEERS.released_elsewhere("lab", 6, 9.0).latch is Latch.NONE
    other = PEERS.released_elsewhere("desk", 6, 9.0)
    assert (other.latch, other.doubt) == (Latch.UNCERTAIN, "console desk released it")
    assert other.released_elsewhere("lab", 7, 10.0).latch is Latch.UNCERTAIN


def test_another_consoles_stop_is_left_to_a_robot_that_reports_it() -> None:
    told = Stop(reports=True).stopped_elsewhere("lab", 5, 3.0, MOTOR, ())
    assert told.latch is Latch.NONE
    assert told.must_be_obeyed(3.0 + OBEYED) == 5


def test_another_consoles_stop_is_not_certain_just_after_a_release() -> None:
    released = Stop().release_accepted(5, 10.0, 6)
    for after, latch in ((SETTLED - JUST_BEFORE, Latch.UNCERTAIN), (SETTLED, Latch.HELD)):
        told = released.stopped_elsewhere("lab", 7, 10.0 + after, MOTOR, ())
        assert told.latch is latch


def test_another_consoles_release_that_is_told_late_does_not_undo_the_stop_behind_it() -> None:
    told = reported(HELD, 5.0, stopped=True).released_elsewhere("lab", 9, 6.0)
    assert (told.latch, told.may_start) == (Latch.HELD, False)
    released = reported(told, 7.0, stopped=False)
    assert (released.latch, released.may_start) == (Latch.NONE, True)
    # Without such a report nobody knows which was last.
    assert HELD.released_elsewhere("lab", 9, 6.0).latch is Latch.UNCERTAIN


# Motion.


def test_a_robot_that_moves_for_a_second_behind_a_stop_has_not_obeyed_it() -> None:
    assert not reported(HELD, OBEYED - JUST_BEFORE, moving=True).is_not_obeyed
    assert reported(HELD, OBEYED, moving=True).is_not_obeyed
    assert HELD.must_be_obeyed(OBEYED - JUST_BEFORE) == 0
    assert HELD.must_be_obeyed(OBEYED) == 2
    asked = answered(called(4.0), now=4.8)  # From when it was asked, not answered.
    assert not reported(asked, 4.9, moving=True).is_not_obeyed
    assert reported(asked, 5.0, moving=True).is_not_obeyed


def test_a_robot_that_was_stopped_by_something_else_has_a_second_to_stand() -> None:
    says = reported(Stop(), 5.0, moving=True, stopped=True)
    for now, is_not_obeyed in ((5.0, False), (5.9, False), (6.0, True)):
        assert reported(says, now, moving=True, stopped=True).is_not_obeyed is is_not_obeyed


def test_a_report_closes_a_stop_that_has_left() -> None:
    assert reported(called(), 1.0, stopped=True).open is None
    assert reported(pressed(), 1.0, stopped=True).open is not None
    assert reported(pressed().leaving(2, MOTOR), 1.0, stopped=True).open is None


def test_a_report_just_after_another_node_came_may_be_of_the_one_before() -> None:
    doubted = HELD.served_by(AGAIN, (), 10.0)
    assert doubted.latch is Latch.UNCERTAIN
    says = Motion(stopped=True, received=0.0)
    early = doubted.moved(says, 10.0 + SETTLED - JUST_BEFORE, AGAIN, ())
    assert early.latch is Latch.UNCERTAIN
    assert doubted.moved(says, 10.0 + SETTLED, AGAIN, ()).latch is Latch.HELD


def test_a_robot_that_stood_and_moves_for_a_second_makes_it_uncertain() -> None:
    begun = reported(reported(HELD, 5.0, moving=False), 6.0, moving=True)
    assert begun.latch is Latch.HELD
    assert reported(begun, 6.9, moving=True).latch is Latch.HELD
    moved = reported(begun, 7.0, moving=True)
    assert (moved.latch, moved.doubt) == (Latch.UNCERTAIN, "the robot moves")
    # What is known to disobey is told as that; what reports its stop is believed.
    disobeying = reported(reported(HELD, 5.0, moving=True), 7.0, moving=True)
    assert (disobeying.latch, disobeying.is_not_obeyed) == (Latch.HELD, True)
    assert reported(begun, 7.0, moving=True, stopped=False).latch is Latch.HELD
    # A pause, or a time that is not known, begins it anew.
    paused = reported(begun, 6.5, moving=False)
    assert reported(paused, 7.0, moving=True).latch is Latch.HELD
    unknown = begun.moved(Motion(moving=True), 6.5, MOTOR, ())
    assert reported(unknown, 7.2, moving=True).latch is Latch.HELD


def test_who_serves_it_is_asked_for_only_when_a_report_changes_something() -> None:
    says = reported(HELD, 5.0, stopped=True)
    for stop, stopped, needs in (
        *((says, False, True), (says, True, False), (HELD, False, False)),
        *((Stop(), True, True), (Stop(), False, False)),
    ):
        assert stop.needs_servers(Motion(stopped=stopped)) is needs


# What follows.


def test_the_later_stop_is_the_one_to_be_obeyed() -> None:
    stop = answered(HELD, now=9.0, turn=5)
    assert answered(stop, now=20.0, turn=2).must_be_obeyed(9.0 + OBEYED) == 5
    same = answered(stop, now=20.0, turn=5)
    assert same.must_be_obeyed(9.0 + OBEYED) == 0
    assert same.must_be_obeyed(20.0 + OBEYED) == 5


def test_an_answer_does_not_put_off_what_is_cancelled() -> None:
    stop = answered(called(), UNCLEAR, 5.0)
    assert (StopEffect.CANCEL_OWN, 2) in stop.tick(5.0, ALL)[1]


def test_goals_from_before_a_later_stop_are_due_with_those_of_the_one_before() -> None:
    closed = called()._replace(open=None)
    assert (StopEffect.CANCEL_OWN, 8) in pressed(8, 0.1, closed).tick(CANCEL_AFTER, ALL)[1]
    later = pressed(8, 5.0, closed)
    assert later.tick(5.1, ALL)[1] == []
    assert (StopEffect.CANCEL_OWN, 8) in later.tick(5.0 + CANCEL_AFTER, ALL)[1]
    assert pressed(8, CANCEL_AFTER, closed).tick(CANCEL_AFTER, ALL)[1] == []


# A STOP is held by nobody only once every node that can hold it has ended in this process.

HERE, ELSEWHERE, NAMESAKE = b"1", b"2", b"3"  # The ids of nodes.
RUNS, ENDED = ["motor"], list[str]()  # The nodes of this process whose code may still run.


def serving(**served: bytes) -> Servers:
    """Nodes by their names; each byte is the id of one."""
    return frozenset((node, frozenset({bytes([n]) for n in ids})) for node, ids in served.items())


def held_by(stop: Stop, here: list[str], **served: bytes) -> Stop:
    """All nodes that serve STOP say yes to a call."""
    servers = serving(**served)
    called = pressed(2, 0.0, stop).leaving(3, servers)
    return answered(called, asked=servers, servers=servers, here=here)


@pytest.mark.parametrize(
    ("holder", "looks"),
    [
        # Its node ran here and has ended, also on the graph.
        (HERE, [(ENDED, {"motor": HERE}, False), (ENDED, {}, True)]),
        # It left, but is not ended: its program is suspended, returns, and holds the STOP.
        (HERE, [(RUNS, {}, False), (RUNS, {"motor": HERE}, False), (ENDED, {}, True)]),
        (HERE + NAMESAKE, [(ENDED, {}, False)]),  # Two nodes of one name.
        (  # A node elsewhere may have got it since.
            HERE,
            [
                (RUNS, {"motor": HERE, "other": ELSEWHERE}, False),
                (ENDED, {"other": ELSEWHERE}, False),
                (ENDED, {}, False),
            ],
        ),
    ],
)
def test_it_is_held_by_nobody_once_all_that_can_hold_it_have_ended_here(
    holder: bytes, looks: Any
) -> None:
    stop = held_by(Stop(), RUNS, motor=holder)
    for here, served, is_held_by_nobody in looks:
        stop = stop.served_by(serving(**served), here, 9.0)
        assert stop.is_held_by_nobody is is_held_by_nobody


def test_one_of_an_ended_nodes_namesake_elsewhere_is_held() -> None:
    stop = held_by(held_by(Stop(), RUNS, motor=HERE), ENDED, motor=ELSEWHERE)
    assert not stop.served_by(NOBODY, ENDED, 9.0).is_held_by_nobody


def test_a_last_report_or_anothers_release_does_not_put_ended_nodes_elsewhere() -> None:
    stop, says = held_by(Stop(), RUNS, motor=HERE), Motion(stopped=True)
    ended = stop.served_by(NOBODY, ENDED, 9.0).moved(says, 9.0, NOBODY, ENDED)
    assert ended.served_by(NOBODY, ENDED, 9.0).is_held_by_nobody
    reporting = stop.moved(says, 9.0, NOBODY, RUNS).served_by(NOBODY, ENDED, 9.0)
    released = reporting.released_elsewhere("other", 9, 9.0)
    assert released.latch is Latch.UNCERTAIN
    assert released.served_by(NOBODY, ENDED, 9.0).is_held_by_nobody
