"""A goal that is followed, by itself: when silence means that it is lost."""

from __future__ import annotations

from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from archo_interfaces.action import MoveToShelf
from rclpy.task import Future

from archo_tui.robot.state import Goal, Motion, Phase, Snapshot
from archo_tui.robot.tracked_goal import TrackedGoal, feedback_changes
from archo_tui.words.goal import goal_line
from archo_tui.words.state import plain_text
from tests.support.archo import SHELF
from tests.support.stub import StandingClock


class ServedAction:
    """An action whose server is there, and does not say how its goals end."""

    is_served = True

    def ask_result(self, goal_id: bytes) -> Future[Any]:
        return Future()


class Feedback:
    def __init__(self, left: float = 5.0) -> None:
        self.distance_remaining = left


@pytest.mark.parametrize(
    ("period", "longest"),
    [(0.5, 3.0), (2.0, 6.0)],
    ids=["three seconds", "three periods"],
)
def test_it_is_lost_after_so_long_without_feedback_though_the_wheels_are_heard(
    period: float, longest: float
) -> None:
    clock = StandingClock()
    goal = Goal(SHELF, {"shelf_number": 3}, Phase.MOVING, clock.monotonic(), clock.now())
    followed = TrackedGoal(goal, b"1", ServedAction(), clock, lambda *_: None)
    for _ in range(3):
        clock.passed += period
        followed.on_feedback(Feedback())
    seen: list[Phase] = []
    for passed in (longest - 0.1, longest + 0.1):
        now = clock.monotonic() + passed
        followed.check(now, Motion(received=now, period=0.2))
        seen.append(followed.goal.phase)
    assert seen == [Phase.MOVING, Phase.LOST]


def followed_at(clock: StandingClock, phase: Phase = Phase.MOVING) -> TrackedGoal:
    goal = Goal(SHELF, {"shelf_number": 3}, phase, clock.monotonic(), clock.now())
    return TrackedGoal(goal, b"1", ServedAction(), clock, lambda *_: None)


def phases(followed: TrackedGoal, clock: StandingClock, *passed: float) -> list[Phase]:
    """Return its phase so many s from now."""
    seen = []
    for seconds in passed:
        followed.check(clock.monotonic() + seconds, Motion())
        seen.append(followed.goal.phase)
    return seen


def test_after_its_first_feedback_it_may_be_silent_for_15_s() -> None:
    clock = StandingClock()
    followed = followed_at(clock)
    followed.on_feedback(Feedback())
    assert phases(followed, clock, 14.9, 15.1) == [Phase.MOVING, Phase.LOST]


def test_without_feedback_and_motion_its_server_alone_decides() -> None:
    clock = StandingClock()
    assert phases(followed_at(clock), clock, 100.0) == [Phase.MOVING]


def test_a_goal_that_is_being_cancelled_may_send_no_feedback_for_15_s() -> None:
    clock = StandingClock()
    followed = followed_at(clock)
    for _ in range(3):
        clock.passed += 0.2
        followed.on_feedback(Feedback())
    followed.update(phase=Phase.CANCELLING, cancel_asked=clock.monotonic())
    assert phases(followed, clock, 14.9, 15.1) == [Phase.CANCELLING, Phase.LOST]


def test_a_parameter_that_is_its_period_counts_at_once() -> None:
    clock = StandingClock()
    followed = followed_at(clock)
    for _ in range(3):
        clock.passed += 0.5
        followed.on_feedback(Feedback())
    followed.forget_period(0.5, 5.0)
    assert phases(followed, clock, 14.9, 15.1) == [Phase.MOVING, Phase.LOST]


def test_silence_while_this_process_stood_still_loses_no_goal() -> None:
    clock = StandingClock()
    followed = followed_at(clock)
    for _ in range(3):
        clock.passed += 0.2
        followed.on_feedback(Feedback())
    resumed = clock.monotonic() + 60.0
    for passed, phase in ((0.0, Phase.MOVING), (2.9, Phase.MOVING), (3.1, Phase.LOST)):
        followed.check(resumed + passed, Motion(), resumed)
        assert followed.goal.phase == phase


def test_the_longest_remainder_is_the_way_until_a_node_tells_it() -> None:
    goal = Goal(SHELF, {}, Phase.MOVING, 0.0, 0.0)
    for left, longest in ((15.0, 15.0), (12.0, 15.0), (16.0, 16.0)):
        goal = goal._replace(
            **feedback_changes(goal, MoveToShelf.Feedback(distance_remaining=left), 0.0)
        )
        assert (goal.length, goal.remaining) == (longest, left)
    known = goal._replace(length=18.0, length_is_guessed=False)
    feedback = MoveToShelf.Feedback(distance_remaining=20.0)
    assert known._replace(**feedback_changes(known, feedback, 0.0)).length == 18.0


def driven(speeds: Iterable[tuple[float, float]], left: float, each: float) -> list[float | None]:
    """Return the seconds left at each feedback of a goal that drives so fast for so long.

    Args:
        speeds: Pairs of speed in m/s and seconds.
        left: The whole way in m.
        each: Seconds between two feedbacks.
    """
    goal, now, found = Goal(SHELF, {}, Phase.MOVING, 0.0, 0.0), 0.0, list[float | None]()
    for speed, seconds in speeds:
        for _ in range(round(seconds / each)):
            feedback = MoveToShelf.Feedback(distance_remaining=left)
            goal = goal._replace(heard=now, **feedback_changes(goal, feedback, now))
            found.append(goal.seconds_left(now))
            now, left = now + each, left - speed * each
    return found


@pytest.mark.parametrize("each", [0.02, 0.1, 0.5, 1.5])
def test_the_time_that_is_left_is_that_of_the_present_speed_or_none(each: float) -> None:
    before, after = 12.0, 12.0
    found = driven([(0.8, before), (0.2, after)], 9.6 + 5.6, each)
    assert found[round(before / each) - 1] == pytest.approx(5.6 / 0.8 + each)
    assert found[-1] == pytest.approx((5.6 - 0.2 * after) / 0.2 + each, rel=0.01)
    changed = round(before / each)
    for number, seconds in enumerate(found[changed:]):
        true = (5.6 - 0.2 * number * each) / 0.2
        if number * each > 0.3:
            assert seconds is None or seconds == pytest.approx(true, rel=0.25)
    at_last = [number * each for number, seconds in enumerate(found[changed:]) if seconds]
    assert at_last[1] < max(2.5, 4 * each)


def test_a_goal_that_stands_or_is_late_has_no_time_left() -> None:
    assert driven([(0.8, 5.0), (0.0, 5.0)], 10.0, 0.1)[-1] is None
    assert driven([(-0.2, 5.0)], 10.0, 0.1)[-1] is None
    assert driven([(0.8, 5.0)], 10.0, 0.1)[:2] == [None] * 2


def test_until_its_period_is_known_a_robot_that_is_silent_has_lost_it_too() -> None:
    clock = StandingClock()
    followed = followed_at(clock)
    followed.on_feedback(Feedback())
    motion = Motion(received=clock.monotonic(), period=0.2)
    for passed, phase in ((2.9, Phase.MOVING), (3.1, Phase.LOST)):
        followed.check(clock.monotonic() + passed, motion)
        assert followed.goal.phase == phase


class Answered:
    """The future of a result whose callbacks have not run yet: to cancel it comes too late."""

    def __init__(self) -> None:
        self.call_back: Any = None

    def add_done_callback(self, call_back: Any) -> None:
        self.call_back = call_back

    def cancel(self) -> None:
        pass

    def cancelled(self) -> bool:
        return False

    def result(self) -> Any:
        return SimpleNamespace(status=GoalStatus.STATUS_UNKNOWN, result=None)


class AskedAction(ServedAction):
    """Its server did not know the goal when it was asked."""

    def __init__(self) -> None:
        self.asked: list[Answered] = []

    def ask_result(self, goal_id: bytes) -> Any:
        self.asked.append(Answered())
        return self.asked[-1]


def test_an_answer_from_before_the_goal_was_taken_does_not_end_it() -> None:
    clock, action = StandingClock(), AskedAction()
    goal = Goal(SHELF, {"shelf_number": 3}, Phase.UNKNOWN, clock.monotonic(), clock.now())
    followed = TrackedGoal(goal, b"1", action, clock, lambda *_: None)
    followed.ask_result()
    followed.on_accepted(object())
    seen: list[Phase] = []
    for asked in action.asked:
        asked.call_back(asked)
        seen.append(followed.goal.phase)
    assert seen == [Phase.MOVING, Phase.ABORTED]


def test_the_time_left_of_a_goal_found_underway_is_judged_by_what_was_seen() -> None:
    clock = StandingClock()
    followed = followed_at(clock)
    followed.update(is_found=True, started=clock.monotonic() - 300.0, length=18.0)
    assert followed.goal.seconds_left(clock.monotonic()) is None
    for left in (12.0, 11.0, 10.0):
        clock.passed += 2.0
        followed.on_feedback(Feedback(left))
    assert followed.goal.seconds_left(clock.monotonic()) == 20.0  # 2 m in 4 s


def test_the_way_of_a_goal_found_underway_is_not_guessed() -> None:
    clock = StandingClock()
    followed = followed_at(clock)
    followed.update(is_found=True, mine=False)
    for left in (12.0, 11.0, 10.0):
        clock.passed += 2.0
        followed.on_feedback(Feedback(left))
    assert followed.goal.length is None
    shown = goal_line(Snapshot(goal=followed.goal), clock.monotonic(), "")
    assert plain_text(shown).endswith("   10.0 m left   6.0 s so far, about 20.0 s left")
