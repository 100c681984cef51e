"""The machine of a goal: each of its rules, and every state that it can reach."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from types import SimpleNamespace

import pytest
from archo_interfaces.action import MoveToShelf

from archo_tui.robot.goals.machine import (
    NEVER_TAKEN,
    Event,
    GoalEffect,
    TrackedGoal,
    end_text,
    feedback_changes,
    found,
    is_missed,
    refusal,
)
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.stop.gate import NEVER_LEFT
from archo_tui.text.goal import goal_line
from tests.robot.explore_goal import FEEDBACK, NEVER, NOW, SUCCESS, sent
from tests.support.archo import SHELF
from tests.support.states import plain_text

pytestmark = pytest.mark.pure


def accepted() -> TrackedGoal:
    return sent().accepted(NOW, is_void=False)._replace(todo=())


def fed(goal: TrackedGoal, *at: float, left: float = 5.0) -> TrackedGoal:
    for now in at:
        goal = goal.fed(SimpleNamespace(distance_remaining=left), now, is_void=False)
    return goal


def phases(goal: TrackedGoal, *at: float, motion: Motion | None = None) -> list[Phase]:
    """Return its phase at these times, of which each comes without the others."""
    return [goal.tick(now, motion or Motion(), NEVER, is_served=True).goal.phase for now in at]


# Silence.


@pytest.mark.parametrize(
    ("period", "longest"), [(0.5, 3.0), (2.0, 6.0)], ids=["three seconds", "three periods"]
)
def test_it_is_lost_after_so_long_without_feedback_though_the_wheels_are_heard(
    period: float, longest: float
) -> None:
    goal, last = fed(accepted(), *(NOW + period * n for n in range(3))), NOW + 2 * period
    for passed, phase in ((longest, Phase.MOVING), (longest + 0.1, Phase.LOST)):
        now = last + passed
        assert phases(goal, now, motion=Motion(received=now, period=0.2)) == [phase]


QUICK = (NOW, NOW + 0.2, NOW + 0.4)


@pytest.mark.parametrize(
    ("goal", "motion", "longest"),
    [
        (fed(accepted(), NOW), Motion(), 15.0),  # After its first feedback.
        (fed(accepted(), *QUICK).cancelling(NOW + 1.0), Motion(), 16.0),  # It may send none then.
        (fed(accepted(), NOW, NOW + 0.5, NOW + 1.0).period_changed(0.5, 5.0), Motion(), 16.0),
        # The robot is silent, too, after three of its periods.
        (fed(accepted(), NOW), Motion(received=NOW, period=0.2), 3.0),
        (accepted(), Motion(received=NOW, period=2.0), 6.0),
    ],
    ids=["first feedback", "cancelled", "parameter", "robot silent", "slow robot"],
)
def test_a_silence_is_judged_by_what_is_known(
    goal: TrackedGoal, motion: Motion, longest: float
) -> None:
    before, lost = phases(goal, NOW + longest - 0.1, NOW + longest + 0.1, motion=motion)
    assert (before, lost) == (goal.goal.phase, Phase.LOST)
    after = goal.tick(NOW + longest + 0.1, motion, NEVER, is_served=True).goal
    assert after.lost == NOW + longest + 0.1


@pytest.mark.parametrize(
    ("phase", "changes", "code", "words"),
    [
        (None, {}, None, ""),
        (Phase.MOVING, {}, Code.REFUSED, "a goal is already running: cancel it first"),
        (Phase.CANCELLING, {}, Code.REFUSED, "a goal is already running: cancel it first"),
        (Phase.UNKNOWN, {}, Code.REFUSED, "nothing is heard of the goal to shelf 3"),
        (Phase.LOST, {}, Code.REFUSED, "nothing is heard of the goal to shelf 3"),
        (None, {"is_called_off": True}, Code.CANCELLED, NEVER_LEFT),
        (None, {"is_served": False}, Code.NOT_OFFERED, "move_to_shelf is not offered by any node"),
        (None, {"has_ended": True}, Code.CANCELLED, "not sent: the console ends"),
    ],
)
def test_a_goal_is_not_sent_beside_ours_to_nobody_or_unwanted(
    phase: Phase | None, changes: dict[str, bool], code: Code | None, words: str
) -> None:
    facts = {"is_called_off": False, "is_served": True, "has_ended": False, **changes}
    goal = sent().called_off() if facts.pop("is_called_off") else sent()
    ours = None if phase is None else goal.goal._replace(phase=phase)
    found = refusal(goal, ours, **facts)
    assert (None if found is None else found.code) is code
    assert found is None or found.text.lstrip("/").startswith(words)


def test_without_a_server_it_is_gone_after_a_second_without_news() -> None:
    goal = accepted().tick(NOW + 5.0, Motion(), NEVER, is_served=False)
    assert goal.tick(NOW + 5.9, Motion(), NEVER, is_served=False).is_running
    assert goal.tick(NOW + 6.0, Motion(), NEVER, is_served=False).goal.phase is Phase.GONE
    heard = fed(goal, NOW + 5.5)
    assert heard.tick(NOW + 6.0, Motion(), NEVER, is_served=False).is_running
    resumed = NOW + 5.5
    assert goal.tick(NOW + 6.0, Motion(), resumed, is_served=False).is_running


# Its way.


def test_the_longest_remainder_is_the_way_until_a_node_tells_it() -> None:
    goal = Goal(SHELF, {}, Phase.MOVING, 0.0, 0.0)
    for left, longest in ((15.0, 15.0), (12.0, 15.0), (16.0, 16.0)):
        feedback = MoveToShelf.Feedback(distance_remaining=left)
        goal = goal._replace(**feedback_changes(goal, feedback, 0.0))
        assert (goal.length, goal.remaining) == (longest, left)
    told = TrackedGoal(goal).with_length(18.0).with_length(19.0).goal
    feedback = MoveToShelf.Feedback(distance_remaining=20.0)
    assert told._replace(**feedback_changes(told, feedback, 0.0)).length == 18.0


def driven(speeds: Iterable[tuple[float, float]], left: float, each: float) -> list[float | None]:
    """Return the seconds left at each feedback of a goal that drives so fast for so long.

    Args:
        speeds: Pairs of speed in m/s and seconds.
        left: The whole way in m.
        each: Seconds between two feedbacks.
    """
    goal, now, seen = Goal(SHELF, {}, Phase.MOVING, 0.0, 0.0), 0.0, list[float | None]()
    for speed, seconds in speeds:
        for _ in range(round(seconds / each)):
            feedback = MoveToShelf.Feedback(distance_remaining=left)
            goal = goal._replace(heard=now, **feedback_changes(goal, feedback, now))
            seen.append(goal.seconds_left(now))
            now, left = now + each, left - speed * each
    return seen


@pytest.mark.parametrize("each", [0.02, 0.1, 0.5, 1.5])
def test_the_time_that_is_left_is_that_of_the_present_speed_or_none(each: float) -> None:
    before, after = 12.0, 12.0
    seen = driven([(0.8, before), (0.2, after)], 9.6 + 5.6, each)
    assert seen[round(before / each) - 1] == pytest.approx(5.6 / 0.8 + each)
    assert seen[-1] == pytest.approx((5.6 - 0.2 * after) / 0.2 + each, rel=0.01)
    changed = round(before / each)
    for number, seconds in enumerate(seen[changed:]):
        true = (5.6 - 0.2 * number * each) / 0.2
        if number * each > 0.3:
            assert seconds is None or seconds == pytest.approx(true, rel=0.25)
    at_last = [number * each for number, seconds in enumerate(seen[changed:]) if seconds]
    assert at_last[1] < max(2.5, 4 * each)


def test_a_goal_that_stands_or_is_late_has_no_time_left() -> None:
    assert driven([(0.8, 5.0), (0.0, 5.0)], 10.0, 0.1)[-1] is None
    assert driven([(-0.2, 5.0)], 10.0, 0.1)[-1] is None
    assert driven([(0.8, 5.0)], 10.0, 0.1)[:2] == [None] * 2


def test_the_way_of_a_goal_found_underway_is_not_guessed() -> None:
    goal = found(SHELF, Phase.MOVING, 2.0, NOW, 7, 1)
    for seconds, left in ((0.0, 12.0), (2.0, 11.0), (4.0, 10.0)):
        goal = fed(goal, NOW + seconds, left=left)
    assert goal.goal.length is None
    shown = goal_line(Snapshot(goal=goal.goal), NOW + 4.0, "")
    assert plain_text(shown).endswith("   10.0 m left   6.0 s so far, about 20.0 s left")


# Its result.


def test_an_answer_from_before_the_goal_was_taken_does_not_end_it() -> None:
    goal = sent().fire(Event.NO_ANSWER, NOW).ask(NOW)
    first = goal.questions
    goal = goal.accepted(NOW, is_void=False)
    assert goal.answered(first, None, None, NOW) is goal
    assert goal.answered(goal.questions, None, None, NOW).goal.phase is Phase.ABORTED


def test_a_goal_that_is_not_taken_may_still_be_so_for_20_s() -> None:
    goal = sent().fire(Event.NO_ANSWER, NOW).ask(NOW)
    question = goal.questions
    assert goal.answered(question, None, None, NOW + NEVER_TAKEN) is goal
    after = goal.answered(question, None, None, NOW + NEVER_TAKEN + 0.1)
    assert after.goal.message.endswith("it did not take it in 20 s")


def test_an_end_by_the_status_waits_2_s_for_the_result() -> None:
    goal = accepted().reported(Event.ARRIVED, NOW, is_canceling=False)
    goal = goal.reported(Event.ABORTED, NOW + 1.0, is_canceling=False)
    assert phases(goal, NOW + 2.0, NOW + 2.1) == [Phase.MOVING, Phase.ARRIVED]
    after = goal.answered(goal.questions, Event.ARRIVED, SUCCESS, NOW + 1.0).goal
    assert (after.phase, after.message, after.remaining) == (Phase.ARRIVED, "there", 0.0)


@pytest.mark.parametrize(
    ("end", "success", "text"),
    [
        (Event.ARRIVED, False, "the action says succeeded, its result says not"),
        (Event.CANCELLED, True, "the action says cancelled, its result says success"),
    ],
)
def test_an_action_whose_result_says_otherwise_is_disputed(
    end: Event, success: bool, text: str
) -> None:
    goal = accepted()
    result = MoveToShelf.Result(success=success)
    after = goal.answered(goal.questions, end, result, NOW).goal
    assert (after.phase, after.message) == (Phase.DISPUTED, text)


# STOP and cancel.


def test_a_goal_that_returns_keeps_its_turn_and_a_stop_since_then_cancels_it() -> None:
    gone = accepted().node_left(NOW)
    back = found(SHELF, Phase.MOVING, 0.0, NOW + 9.0, 90, 2)
    assert gone.is_back(NOW + 1.0, is_served=True)
    assert not gone.is_back(NOW + 0.9, is_served=True)
    assert not gone.is_back(NOW + 9.0, is_served=False)
    again = gone.found_again(back, is_void=True)
    assert (again.turn, again.goal.mine, again.goal.name) == (5, True, "shelf 3")
    assert again.todo == (GoalEffect.ASK, GoalEffect.CANCEL)
    assert gone.found_again(back, is_void=False).todo == (GoalEffect.ASK,)
    assert gone.found_again(back._replace(goal=back.goal), is_void=False).goal.is_found


def test_behind_a_stop_it_is_cancelled_every_2_s_and_no_phase_tells_it() -> None:
    goal = accepted().behind_stop(6, NOW)
    assert (goal.todo, goal.goal.phase) == ((GoalEffect.CANCEL_UNASKED,), Phase.MOVING)
    goal = goal._replace(todo=())
    assert goal.behind_stop(6, NOW + 2.0).todo == ()
    assert goal.behind_stop(6, NOW + 2.1).todo == (GoalEffect.CANCEL_UNASKED,)
    assert accepted().behind_stop(5, NOW).todo == ()  # It was sent behind the STOP.
    assert sent().behind_stop(6, NOW).todo == ()  # It is void, and cancelled when accepted.
    assert accepted().cancelled_with_all(NOW).behind_stop(6, NOW + 1.0).todo == ()


@pytest.mark.parametrize("before", [Phase.MOVING, Phase.UNKNOWN, Phase.LOST])
def test_a_cancel_that_failed_returns_to_the_phase_before(before: Phase) -> None:
    goal = accepted()
    goal = goal._replace(goal=goal.goal._replace(phase=before)).cancelling(NOW)
    assert (goal.goal.phase, goal.goal.cancel_asked) == (Phase.CANCELLING, NOW)
    failed = goal.cancel_failed(NOW, is_rejected=False).goal
    assert (failed.phase, failed.cancel_asked) == (before, None)
    assert goal.cancel_failed(NOW, is_rejected=True).todo == (GoalEffect.ASK,)
    twice = goal.cancelling(NOW).cancel_failed(NOW, is_rejected=False)
    assert twice.goal.phase is Phase.CANCELLING  # The other one is still awaited.
    assert twice.cancel_failed(NOW, is_rejected=False).goal.phase is before
    assert twice.cancel_accepted().goal.phase is Phase.CANCELLING


@pytest.mark.parametrize(("cancels", "phase"), [(1, Phase.LOST), (2, Phase.CANCELLING)])
def test_a_yes_to_a_cancel_is_one_answer_less_that_is_awaited(cancels: int, phase: Phase) -> None:
    goal = accepted()
    for _ in range(cancels):
        goal = goal.cancelling(NOW)
    again = goal.cancel_accepted().fire(Event.SILENT, NOW).cancelling(NOW)
    assert again.cancel_failed(NOW, is_rejected=False).goal.phase is phase


def test_a_cancel_that_fails_behind_the_yes_to_another_changes_nothing() -> None:
    taken = accepted().cancelling(NOW).cancelling(NOW).cancel_accepted()
    failed = taken.cancel_failed(NOW + 1.0, is_rejected=False)
    assert (failed.goal, failed.awaited) == (taken.goal, 0)


# Goals of others.


@pytest.mark.parametrize(
    ("age", "tracked_for", "was_reported", "is_news"),
    [
        (3.0, 5.0, None, True),
        (5.0, 5.0, None, True),
        (7.0, 5.0, None, False),  # It ended before the console began.
        (7.0, 5.0, False, True),
        (3.0, 5.0, True, False),
    ],
)
def test_a_goal_that_began_and_ended_between_two_messages_is_history(
    age: float, tracked_for: float, was_reported: bool | None, is_news: bool
) -> None:
    assert is_missed(age, tracked_for, was_reported) is is_news


@pytest.mark.parametrize(
    ("age", "is_first", "begun", "is_found"),
    [
        (0.0, True, NOW, False),
        (0.5, True, NOW - 0.5, False),
        (1.0, True, NOW - 1.0, True),
        (86_400.0, True, NOW - 86_400.0, True),
        (86_400.5, True, NOW, True),
        (300.0, False, NOW - 300.0, False),
        (-5.0, True, NOW, True),  # The robot's clock is ahead,
        (1e6, True, NOW, True),  # or began with the robot.
    ],
)
def test_a_found_goal_began_when_its_server_says_unless_that_cannot_be(
    age: float, is_first: bool, begun: float, is_found: bool
) -> None:
    goal = found(SHELF, Phase.MOVING, age, NOW, 7, 1, is_first=is_first).goal
    expected = Goal(SHELF, {}, Phase.MOVING, begun, 0.0, mine=False, number=1)
    assert goal == expected._replace(heard=NOW, started=begun, is_found=is_found)
    assert found(SHELF, Phase.CANCELLING, age, NOW, 7, 1).goal.cancel_asked == NOW


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


def test_it_is_taken_as_accepted_since_it_was_sent_if_feedback_says_so() -> None:
    early = sent().fed(FEEDBACK, NOW + 1.0, is_void=False)
    assert (early.goal.started, early.goal.heard) == (NOW, NOW + 1.0)
    known = sent().accepted(NOW + 1.0, is_void=False).fed(FEEDBACK, NOW + 2.0, is_void=False)
    assert known.goal.started == NOW + 1.0


# Its end.


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


# What is asked, and when.


def test_its_server_is_asked_about_it_without_news_or_in_doubt() -> None:
    assert asks(accepted(), NOW + 5.0, NOW + 5.1) == [False, True]
    assert asks(fed(accepted(), NOW + 1.0), NOW + 6.0, NOW + 6.1) == [False, True]
    assert asks(accepted().ask(NOW + 1.0), NOW + 6.0, NOW + 6.1) == [False, True]
    for doubtful in (unknown(), lost()):
        assert asks(doubtful.ask(NOW + 1.0), NOW + 3.0, NOW + 3.1) == [False, True]
    assert asks(sent(), NOW + 60.0) == [False]
    assert asks(accepted(), NOW + 60.0, is_served=False) == [False]


def test_a_goal_whose_robot_is_heard_again_is_asked_about_at_once() -> None:
    asked = lost().ask(NOW)
    assert asks(asked.robot_heard(NOW), NOW + 0.1) == [True]
    assert accepted().robot_heard(NOW) == accepted()


# Its feedback.


def test_a_remainder_is_a_reading_up_to_1000_km_or_shown_as_it_came() -> None:
    for left in (0.0, 0.5, 1e6):
        changes = feedback_changes(GOAL, SimpleNamespace(distance_remaining=left), NOW)
        assert (changes["remaining"], changes["length"]) == (left, left)
    for value, shown in ((1e6 + 0.5, "1e+06"), (-0.5, "-0.5"), ("far", "far")):
        changes = feedback_changes(GOAL, SimpleNamespace(distance_remaining=value), NOW)
        assert changes == {"unreadable": shown}
    feedback = MoveToShelf.Feedback(distance_remaining=1.5)  # Without a named remainder.
    changes = feedback_changes(GOAL._replace(kind=PLAIN), feedback, NOW)
    assert changes == {"feedback": "distance_remaining 1.5"}


def test_a_status_leaves_our_cancel_as_it_was_asked() -> None:
    goal = accepted().cancelling(NOW)
    assert goal.reported(None, NOW + 1.0, is_canceling=True).goal.cancel_asked == NOW
    unsaid = goal.reported(None, NOW + 1.0, is_canceling=False)
    assert unsaid.cancel_failed(NOW, is_rejected=False).goal.phase is Phase.MOVING
