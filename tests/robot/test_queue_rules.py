"""The rules of the queue of goals one by one: numbers, answers, who leaves, and what holds it."""

from __future__ import annotations

import pytest

from archo_tui.robot.clients import YOU, Requester
from archo_tui.robot.goals.queue import Deed, GoalQueue, OnItsWay, QueueEffect
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.stop.gate import NEVER_LEFT
from tests.robot.test_goal_queue import ARRIVED, YES, ended, queue, running, target
from tests.support.archo import SHELF

pytestmark = pytest.mark.pure

SHELL = Requester("SHELL", "pid 4711")
SHELL.waits = True
NOBODY = Snapshot()
REFUSED, SILENT = Outcome(Code.REFUSED, "no"), Outcome(Code.TIMEOUT, "no answer in 5 s")
STOPPED = Outcome(Code.HELD, "not sent")


def typed(*shelves: int, by: Requester = SHELL) -> GoalQueue:
    """A queue of a list of goals of which the first is on its way."""
    goals = [target(shelf)._replace(requester=by) for shelf in shelves]
    return GoalQueue().submit(goals, NOBODY)._replace(todo=())


def answered(outcome: Outcome, *shelves: int, by: Requester = YOU) -> GoalQueue:
    """A queue behind the robot's answer to the first goal of a list."""
    return typed(*shelves, by=by).hand_over().answered(outcome)


def done(after: GoalQueue) -> list[tuple[QueueEffect, str, str]]:
    """Return what is to be done, each with the goal and the text that it takes."""
    return [
        (
            deed.do,
            deed.goal.text if deed.goal else "",
            deed.outcome.text if deed.outcome else deed.text,
        )
        for deed in after.todo
    ]


# What is typed.


def test_goals_are_numbered_as_typed_and_the_first_of_each_list_leads_it() -> None:
    lists = typed(0, 7, by=YOU).submit([target(3), target(4)], NOBODY)
    assert lists.coming is not None
    goals = (lists.coming.goal, *lists.waiting)
    numbers = [(goal.text, goal.number, goal.list_number, goal.is_first) for goal in goals]
    expected = [("0", 1, 1, True), ("7", 2, 1, False), ("3", 3, 3, True), ("4", 4, 3, False)]
    assert (numbers, lists.submitted) == (expected, 4)


def test_a_goal_that_leaves_at_once_did_not_wait_as_a_queued_one_did() -> None:
    for before, snapshot in ((0, NOBODY), (8, ARRIVED._replace(history=(ended(7), ended(4))))):
        at_once = GoalQueue().submit([target(1)], snapshot)
        assert at_once.coming is not None
        goal = at_once.coming.goal
        assert at_once.coming == OnItsWay(goal, before, False, False, False, False)
        assert at_once.todo == (Deed(QueueEffect.SEND, goal),)
    waited = queue(7).seen(ARRIVED, 0.0, 0).coming
    assert waited is not None
    assert waited.waited


def test_a_goal_on_its_way_is_shown_as_sent_until_it_is_seen() -> None:
    shown = typed(7).running_goal(NOBODY)
    assert shown == Goal(SHELF, {"shelf_number": 7}, Phase.SENT, 0.0, 0.0)


def test_a_new_list_behind_a_held_queue_is_held_but_for_its_first() -> None:
    held = GoalQueue().restore([target(1)])._replace(todo=())
    after = held.submit([target(3), target(4)], NOBODY)
    assert done(after) == [
        (QueueEffect.SEND, "3", ""),
        (QueueEffect.SETTLE, "4", "held: 4 (restart)"),
    ]
    assert [goal.text for goal in after.waiting] == ["1", "4"]


def test_what_is_taken_over_at_a_restart_is_held_and_none_is_sent() -> None:
    restored = GoalQueue().restore([target(1), target(2)])
    assert (restored.coming, restored.hold_reason) == (None, "restart")
    held = [(QueueEffect.SETTLE, text, f"held: {text} (restart)") for text in ("1", "2")]
    assert done(restored) == [(QueueEffect.NOTE, "", "queue held: 1, 2 (restart)"), *held]
    assert GoalQueue().restore([]) == GoalQueue()


def test_a_queue_is_held_until_its_last_goal_is_left_out() -> None:
    held = GoalQueue().restore([target(1), target(2)])
    one = held.skip()
    assert (one.hold_reason, one.skip().hold_reason) == ("restart", "")


# Its way.


def test_a_goal_is_called_off_until_it_is_handed_over() -> None:
    coming = typed(1)
    called_off, over = coming.call_off().coming, coming.hand_over()
    assert (called_off and called_off.is_called_off, over.call_off()) == (True, over)
    assert over.coming is not None
    assert over.coming.is_handed_over


def test_a_screen_that_ends_settles_what_it_did_not_send_and_forgets_the_rest() -> None:
    coming = typed(1)
    settled = [(what, "1", NEVER_LEFT) for what in (QueueEffect.SETTLE, QueueEffect.ANSWER)]
    assert done(coming.drop()) == settled
    assert coming.drop().coming is None
    over = coming.hand_over()
    assert over.drop() == over
    assert over.lose() == over._replace(coming=None)
    waiting = queue(7)
    assert waiting.drop() == waiting.call_off() == waiting  # None is on its way.


# Its answer.


def test_a_goal_held_back_by_a_stop_waits_again_as_the_next_one() -> None:
    after = answered(STOPPED, 1, 2)
    assert [goal.text for goal in after.waiting] == ["1", "2"]
    assert (after.coming, after.hold_reason) == (None, "STOP")
    first, *_, last = done(after)
    assert first == (QueueEffect.NOTE, "", "queue held: 1, 2 (STOP)")
    assert last == (QueueEffect.ANSWER, "1", "not sent")


def test_a_goal_held_back_by_a_stop_keeps_the_reason_of_its_queue() -> None:
    held = GoalQueue().restore([target(1)])._replace(todo=())
    after = held.submit([target(3)], NOBODY)._replace(todo=()).hand_over().answered(STOPPED)
    told = [(QueueEffect.SETTLE, "3", "held: 3 (restart)"), (QueueEffect.ANSWER, "3", "not sent")]
    assert (done(after), after.hold_reason) == (told, "restart")


def test_a_goal_held_back_by_a_stop_ends_if_its_requester_has_left() -> None:
    after = typed(1).hand_over().leave(SHELL).answered(STOPPED)
    assert done(after) == [
        (QueueEffect.SETTLE, "1", NEVER_LEFT),
        (QueueEffect.ANSWER, "1", NEVER_LEFT),
    ]
    assert after.waiting == ()


def test_a_list_whose_first_goal_is_refused_is_not_driven() -> None:
    after = answered(REFUSED, 1, 2, 3)
    assert after.waiting == ()
    out = "taken out of the queue:"
    why = "no; not driven either: 2, 3"
    assert done(after) == [
        *((QueueEffect.SETTLE, "2", f"{out} 2"), (QueueEffect.SETTLE, "3", f"{out} 3")),
        (QueueEffect.NOTE, "", "left out of the queue: 2, 3 (1 was refused)"),
        *((QueueEffect.SETTLE, "1", why), (QueueEffect.ANSWER, "1", why)),
    ]
    alone = answered(REFUSED, 1)
    assert done(alone) == [(QueueEffect.SETTLE, "1", "no"), (QueueEffect.ANSWER, "1", "no")]


@pytest.mark.parametrize(
    ("outcome", "reason"),
    [(SILENT, "no answer"), (Outcome(Code.CANCELLED, ""), "cancelled")],
)
def test_a_list_whose_first_goal_fails_otherwise_is_held(outcome: Outcome, reason: str) -> None:
    after = answered(outcome, 1, 2)
    assert ([goal.text for goal in after.waiting], after.hold_reason) == (["2"], reason)


def test_a_refusal_of_a_later_goal_holds_those_behind_it() -> None:
    second = queue(7, 3).seen(ARRIVED, 0.0, 0).hand_over()
    after = second.answered(REFUSED)
    assert ([goal.text for goal in after.waiting], after.hold_reason) == (["3"], "refused")


@pytest.mark.parametrize(
    ("outcome", "by", "has_left", "is_cancelled"),
    [
        (YES, SHELL, False, False),
        (YES, SHELL, True, True),
        (SILENT, YOU, False, False),
        (SILENT, SHELL, False, True),
        (SILENT, SHELL, True, True),
        (SILENT, YOU, True, True),
        (REFUSED, SHELL, False, False),
        (REFUSED, SHELL, True, False),
    ],
)
def test_a_goal_that_may_run_for_nobody_is_cancelled(
    outcome: Outcome, by: Requester, has_left: bool, is_cancelled: bool
) -> None:
    over = typed(1, by=by).hand_over()
    after = (over.leave(by) if has_left else over).answered(outcome)
    assert (QueueEffect.CANCEL in [deed.do for deed in after.todo]) is is_cancelled


# Those that leave.


def test_what_a_client_wanted_goes_with_it_and_what_others_want_stays() -> None:
    both = typed(1, 2).submit([target(3)], NOBODY)
    left = both.leave(SHELL)
    assert left.coming is not None
    assert (left.coming.is_called_off, left.coming.is_abandoned) == (True, True)
    why = "left out of the queue: 2 (nobody waits for it any more)"
    out = [(QueueEffect.SETTLE, "2", "taken out of the queue: 2"), (QueueEffect.NOTE, "", why)]
    assert done(left) == out
    assert [goal.text for goal in left.waiting] == ["3"]
    assert both.take_out(SHELL) == left._replace(coming=both.coming)


def test_one_that_leaves_takes_no_goal_of_another_along() -> None:
    ours = typed(1, 2, by=YOU)
    assert ours.leave(SHELL) == ours
    assert GoalQueue().leave(SHELL) == GoalQueue()


# What is seen.


def test_a_goal_is_settled_with_its_end_which_its_requester_is_shown() -> None:
    after = queue().seen(ARRIVED, 0.0, 0)
    (settled,) = after.todo
    assert (settled.do, settled.goal and settled.goal.number) == (QueueEffect.SETTLE, 1)
    assert (settled.outcome, settled.ended) == (Outcome(Code.ARRIVED, "arrived"), ARRIVED.goal)


@pytest.mark.parametrize(
    ("is_shown", "mine", "reason"),
    [
        (True, True, "aborted"),
        (True, False, "aborted"),
        (False, True, "aborted"),
        (False, False, ""),
    ],
)
def test_a_goal_that_failed_holds_the_queue_if_it_is_ours_or_shown(
    is_shown: bool, mine: bool, reason: str
) -> None:
    failed = ended(5, Phase.ABORTED)._replace(mine=mine)
    shown = failed if is_shown else running(9, mine=False)
    after = queue(7).seen(Snapshot(goal=shown, history=(failed,)), 0.0, 0)
    assert after.hold_reason == reason


def test_a_queue_that_is_held_is_not_told_so_again() -> None:
    held = GoalQueue().restore([target(1)])._replace(todo=())
    failed = held.seen(Snapshot(goal=ended(5, Phase.ABORTED)), 0.0, 0)
    assert (failed.hold_reason, failed.todo) == ("restart", ())
