"""The rules of a goal one by one: to the second, late answers, an end, and the words for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import pytest
from archo_interfaces.action import MoveToShelf

from archo_tui.robot.goals.machine import (
    Event,
    GoalEffect,
    TrackedGoal,
    end_text,
    feedback_changes,
    found,
    is_missed,
    refusal,
)
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.stop.gate import NEVER_LEFT
from tests.robot.test_goal_machine import FEEDBACK, NEVER, NOW, accepted, fed, phases, sent
from tests.support.archo import SHELF

pytestmark = pytest.mark.pure

PLAIN = replace(SHELF, remaining=None, message="")  # Its file names no field of its messages.
GOAL = Goal(SHELF, {"shelf_number": 3}, Phase.MOVING, NOW, 0.0)


def unknown() -> TrackedGoal:
    return sent().fire(Event.NO_ANSWER, NOW)


def lost() -> TrackedGoal:
    return accepted().fire(Event.SILENT, NOW)


def asks(goal: TrackedGoal, *at: float, is_served: bool = True) -> list[bool]:
    """Return if its server is asked about it at these times, each without the others."""
    goal = goal._replace(todo=())
    ticks = (goal.tick(now, Motion(), NEVER, is_served=is_served) for now in at)
    return [tick.todo == (GoalEffect.ASK,) for tick in ticks]


# Its request.


def test_it_is_from_when_it_left_and_from_before_all_stops_until_then() -> None:
    goal = TrackedGoal(GOAL._replace(sent=0.0))
    assert goal.behind_stop(1, NOW).todo == (GoalEffect.CANCEL_UNASKED,)
    left = goal.leaving(NOW, 5, 7)
    assert (left.goal.sent, left.goal.number, left.turn) == (NOW, 7, 5)


def test_a_refusal_in_time_waits_for_its_reason_and_a_late_one_ends_it() -> None:
    assert sent().refused_late(NOW) == sent()
    late = unknown().refused_late(NOW).goal
    assert (late.phase, late.message) == (Phase.REFUSED, "refused (the answer came late)")


def test_it_is_taken_as_accepted_since_it_was_sent_if_feedback_says_so() -> None:
    early = sent().fed(FEEDBACK, NOW + 1.0, is_void=False)
    assert (early.goal.started, early.goal.heard) == (NOW, NOW + 1.0)
    known = sent().accepted(NOW + 1.0, is_void=False).fed(FEEDBACK, NOW + 2.0, is_void=False)
    assert known.goal.started == NOW + 1.0


def test_only_a_goal_without_an_answer_is_called_off() -> None:
    for goal, is_cancelled in ((sent(), True), (unknown(), True), (accepted(), False)):
        assert goal.called_off() == goal._replace(is_cancelled=is_cancelled)


def test_a_goal_that_is_not_wanted_any_more_is_cancelled_once_when_accepted() -> None:
    for goal, is_void in ((sent(), True), (sent().called_off(), False)):
        after = goal.accepted(NOW, is_void=is_void)
        assert after.todo == (GoalEffect.ASK, GoalEffect.CANCEL)
        again = after.cancelled_if_unwanted(is_void=is_void)
        assert again == after


def test_feedback_of_a_goal_without_an_answer_cancels_it_if_not_wanted() -> None:
    assert unknown().fed(FEEDBACK, NOW, is_void=True).todo == (GoalEffect.CANCEL,)
    assert unknown().fed(FEEDBACK, NOW, is_void=False).todo == ()
    silent = unknown().called_off().cancelling(NOW).fire(Event.SILENT, NOW)
    assert silent.goal.phase is Phase.LOST
    assert silent.fed(FEEDBACK, NOW, is_void=False).todo == (GoalEffect.CANCEL,)


def test_a_goal_that_was_called_off_never_leaves() -> None:
    called_off = refusal(sent().called_off(), None, is_served=True, has_ended=False)
    assert called_off == Outcome(Code.CANCELLED, NEVER_LEFT)


# Its end.


def test_an_ended_goal_changes_no_more() -> None:
    ended = accepted().cancelling(NOW).fire(Event.ARRIVED, NOW, "there")
    for after in (
        ended.fire(Event.NODE_LEFT, NOW + 1.0),
        ended.refused_late(NOW + 1.0),
        ended.accepted(NOW + 1.0, is_void=False),
        ended.cancelled_if_unwanted(is_void=True),
        ended.called_off(),
        ended.cancelling(NOW + 1.0),
        ended.cancel_accepted(),
        ended.cancel_failed(NOW + 1.0, is_rejected=True),
        ended.behind_stop(9, NOW + 1.0),
        ended.fed(FEEDBACK, NOW + 1.0, is_void=True),
        ended.reported(Event.ABORTED, NOW + 1.0, is_canceling=True),
        ended.ask(NOW + 1.0),
        ended.tick(NOW + 60.0, Motion(), NEVER, is_served=False),
    ):
        assert after == ended


def test_a_goal_accepted_after_its_end_is_cancelled_unless_it_was_before() -> None:
    never = unknown().fire(Event.ABORTED, NOW)
    assert never.accepted(NOW, is_void=False).todo == (GoalEffect.CANCEL_ENDED,)
    left = accepted().node_left(NOW)
    assert left.accepted(NOW, is_void=False).todo == ()
    assert left.accepted(NOW, is_void=True).todo == (GoalEffect.CANCEL_ENDED,)
    called_off = left._replace(is_cancelled=True)
    assert called_off.accepted(NOW, is_void=False).todo == (GoalEffect.CANCEL_ENDED,)


@pytest.mark.parametrize(
    ("end", "words", "message", "left"),
    [
        (Event.ARRIVED, "", "", 0.0),
        (Event.ARRIVED, "there", "there", 0.0),
        (Event.ABORTED, "", "the robot gave no reason", 5.0),
        (Event.ABORTED, "no way", "no way", 5.0),
    ],
)
def test_an_end_has_the_robots_words_and_only_an_arrival_leaves_no_way(
    end: Event, words: str, message: str, left: float
) -> None:
    goal = fed(accepted(), NOW)
    result = SimpleNamespace(final_message=words)
    ended = goal.answered(goal.questions, end, result, NOW).goal
    assert (ended.message, ended.remaining, ended.result) == (message, left, result)


def test_a_goal_without_a_way_arrives_without_one() -> None:
    goal = TrackedGoal(GOAL._replace(kind=PLAIN))
    ended = goal.answered(0, Event.ARRIVED, MoveToShelf.Result(success=True), NOW).goal
    assert (ended.remaining, ended.message) == (None, "success true")


@pytest.mark.parametrize(
    ("phase", "before", "message", "text"),
    [
        (Phase.REFUSED, Phase.SENT, "busy", ""),  # Its verb says it.
        (Phase.REFUSED, Phase.UNKNOWN, "busy", "shelf 3 refused: busy"),
        (Phase.GONE, Phase.SENT, "", "shelf 3 lost"),
        (Phase.ABORTED, Phase.MOVING, "", "shelf 3 aborted"),
        (Phase.ABORTED, Phase.MOVING, "by hand", "shelf 3 aborted: by hand"),
        (Phase.ABORTED, Phase.MOVING, "Aborted by hand", "shelf 3 aborted: Aborted by hand"),
        (Phase.ABORTED, Phase.MOVING, "No shelf 3", "shelf 3 aborted: No shelf 3"),
        (Phase.ABORTED, Phase.MOVING, "Shelf 3 was aborted", "Shelf 3 was aborted"),
    ],
)
def test_an_end_is_told_in_the_robots_words_if_they_say_it_all(
    phase: Phase, before: Phase, message: str, text: str
) -> None:
    ended = GOAL._replace(phase=phase, message=message)
    assert end_text(GOAL._replace(phase=before), ended) == text


# Its cancel.


def test_a_goal_without_an_answer_is_not_cancelled_yet() -> None:
    assert sent().cancelling(NOW) == sent()


@pytest.mark.parametrize(("cancels", "phase"), [(1, Phase.LOST), (2, Phase.CANCELLING)])
def test_a_yes_to_a_cancel_is_one_answer_less_that_is_awaited(cancels: int, phase: Phase) -> None:
    goal = accepted()
    for _ in range(cancels):
        goal = goal.cancelling(NOW)
    again = goal.cancel_accepted().fire(Event.SILENT, NOW).cancelling(NOW)
    assert again.cancel_failed(NOW, is_rejected=False).goal.phase is phase


def test_a_status_tells_of_a_cancel_by_another_client() -> None:
    told = accepted().reported(None, NOW + 1.0, is_canceling=True)
    assert (told.goal.phase, told.goal.cancel_asked) == (Phase.CANCELLING, NOW + 1.0)
    assert told.cancel_failed(NOW, is_rejected=False).goal.phase is Phase.CANCELLING
    assert accepted().reported(None, NOW, is_canceling=False) == accepted()


def test_a_status_leaves_our_cancel_as_it_was_asked() -> None:
    goal = accepted().cancelling(NOW)
    assert goal.reported(None, NOW + 1.0, is_canceling=True).goal.cancel_asked == NOW
    unsaid = goal.reported(None, NOW + 1.0, is_canceling=False)
    assert unsaid.cancel_failed(NOW, is_rejected=False).goal.phase is Phase.MOVING


# What is asked, and when.


def test_its_questions_are_counted_from_1() -> None:
    assert sent().questions == 0
    assert sent().ask(NOW).questions == 1


def test_its_server_is_asked_about_it_after_5_s_without_news() -> None:
    assert asks(accepted(), NOW + 5.0, NOW + 5.1) == [False, True]
    assert asks(fed(accepted(), NOW + 1.0), NOW + 6.0, NOW + 6.1) == [False, True]
    asked = accepted().ask(NOW + 1.0)
    assert asks(asked, NOW + 6.0, NOW + 6.1) == [False, True]


@pytest.mark.parametrize("doubtful", [unknown, lost])
def test_a_doubtful_goal_is_asked_about_every_2_s(doubtful: Callable[[], TrackedGoal]) -> None:
    assert asks(doubtful().ask(NOW + 1.0), NOW + 3.0, NOW + 3.1) == [False, True]


def test_a_goal_without_an_answer_or_a_server_is_not_asked_about() -> None:
    assert asks(sent(), NOW + 60.0) == [False]
    assert asks(accepted(), NOW + 60.0, is_served=False) == [False]


def test_a_goal_whose_robot_is_heard_again_is_asked_about_at_once() -> None:
    asked = lost().ask(NOW)
    assert asks(asked.robot_heard(NOW), NOW + 0.1) == [True]
    assert accepted().robot_heard(NOW) == accepted()


def test_the_longest_silences_are_no_loss_yet() -> None:
    assert phases(fed(accepted(), NOW, NOW + 0.5, NOW + 1.0), NOW + 4.0) == [Phase.MOVING]
    assert phases(fed(accepted(), NOW), NOW + 15.0) == [Phase.MOVING]
    motion = Motion(received=NOW, period=0.2)
    assert phases(accepted(), NOW + 3.0, motion=motion) == [Phase.MOVING]


# Goals of others, and those that return.


@pytest.mark.parametrize(
    ("age", "begun", "is_found"),
    [
        (0.0, NOW, False),
        (1.0, NOW - 1.0, True),
        (86_400.0, NOW - 86_400.0, True),
        (86_400.5, NOW, True),
    ],
)
def test_the_age_of_a_found_goal_is_believed_for_a_day(
    age: float, begun: float, is_found: bool
) -> None:
    goal = found(SHELF, Phase.MOVING, age, NOW, 7, 1).goal
    expected = Goal(SHELF, {}, Phase.MOVING, begun, 0.0, mine=False, number=1)
    assert goal == expected._replace(heard=NOW, started=begun, is_found=is_found)


def test_the_cancel_of_a_found_goal_counts_from_when_it_was_found() -> None:
    goal = found(SHELF, Phase.CANCELLING, 300.0, NOW, 7, 1).goal
    assert goal.cancel_asked == NOW


def test_a_goal_that_returns_was_underway_when_it_was_seen_again() -> None:
    back = found(SHELF, Phase.MOVING, 0.0, NOW + 9.0, 90, 2, is_first=False)
    assert accepted().node_left(NOW).found_again(back, is_void=False).goal.is_found


def test_a_goal_as_old_as_the_watch_over_its_action_is_news() -> None:
    assert is_missed(5.0, 5.0, None)


# Its feedback.


@pytest.mark.parametrize("left", [0.0, 0.5, 1e6])
def test_a_remainder_up_to_1000_km_is_a_reading_and_the_way(left: float) -> None:
    feedback = SimpleNamespace(distance_remaining=left)
    changes = feedback_changes(GOAL, feedback, NOW)
    assert (changes["remaining"], changes["length"]) == (left, left)


@pytest.mark.parametrize(("value", "shown"), [(1e6 + 0.5, "1e+06"), (-0.5, "-0.5"), ("far", "far")])
def test_any_other_remainder_is_shown_as_it_came(value: object, shown: str) -> None:
    feedback = SimpleNamespace(distance_remaining=value)
    assert feedback_changes(GOAL, feedback, NOW) == {"unreadable": shown}


def test_without_a_named_remainder_the_whole_feedback_is_shown() -> None:
    feedback = MoveToShelf.Feedback(distance_remaining=1.5)
    changes = feedback_changes(GOAL._replace(kind=PLAIN), feedback, NOW)
    assert changes == {"feedback": "distance_remaining 1.5"}
