"""The queue of goals: what holds it, and what goes on."""

from __future__ import annotations

from typing import Any

import pytest

from archo_tui.robot.clients import YOU, Requester
from archo_tui.robot.goals.queue import Deed, GoalQueue, OnItsWay, QueuedGoal, QueueEffect
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import OpenStop, Snapshot
from archo_tui.robot.stop.gate import NEVER_LEFT
from archo_tui.station.alarms import Alarm, AlarmState, holding
from archo_tui.station.conditions import BATTERY_EMPTY, CONTACT_LOST, LOW_BATTERY
from tests.support.archo import ARCHO, SHELF

pytestmark = pytest.mark.pure

YES = Outcome(Code.ACCEPTED, "accepted")


def target(number: int) -> QueuedGoal:
    return QueuedGoal(SHELF, {"shelf_number": number})


def ended(number: int, phase: Phase = Phase.ARRIVED) -> Goal:
    return Goal(SHELF, {"shelf_number": number}, phase, 0.0, 0.0, number=number + 1)


ARRIVED = Snapshot(file=ARCHO, goal=ended(0))


def queue(*numbers: int) -> GoalQueue:
    """What waits behind a goal that the robot has accepted."""
    goals = [target(0), *map(target, numbers)]
    made = GoalQueue().submit(goals, Snapshot(file=ARCHO)).hand_over().answered(YES)
    return made._replace(todo=())


def look(
    waiting: GoalQueue, snapshot: Snapshot, alarms: Any = (), stops: int = 0
) -> tuple[GoalQueue, str]:
    """The queue after a look at the robot, and what is sent then."""
    after = waiting.seen(snapshot, 0.0, stops, holding(alarms))
    sent = [deed.goal.text for deed in after.todo if deed.do is QueueEffect.SEND and deed.goal]
    return after._replace(todo=()), ", ".join(sent)


@pytest.mark.parametrize(
    ("change", "alarms", "why"),
    [
        ({"goal": ended(0, Phase.ABORTED)}, [], "aborted"),
        ({"goal": ended(0, Phase.DISPUTED)}, [], "ended"),
        ({"goal": ended(0, Phase.ABORTED), "motion": Motion(stopped=True)}, [], "STOP"),
        ({"goal": ended(0, Phase.ABORTED), "open_stop": OpenStop(1.0)}, [], "STOP"),
        ({"goal": ended(0, Phase.CANCELLED)}, [Alarm(LOW_BATTERY, "", 0.0)], "cancelled"),
        ({"open_stop": OpenStop(1.0)}, [], "STOP"),
        ({"motion": Motion(stopped=True)}, [], "STOP"),
        ({}, [Alarm(LOW_BATTERY, "", 0.0)], LOW_BATTERY),
        ({}, [Alarm(BATTERY_EMPTY, "", 0.0)], BATTERY_EMPTY),
        ({}, [Alarm(CONTACT_LOST, "", 0.0)], CONTACT_LOST),
    ],
)
def test_what_holds_the_queue_stays_until_the_operator_goes_on(
    change: dict[str, Any], alarms: list[Alarm], why: str
) -> None:
    seen = Snapshot(file=ARCHO, **{"goal": ended(0), **change})
    waiting, sent = look(queue(7), seen, alarms)
    assert (sent, waiting.hold_reason.removeprefix("was: ")) == ("", why)
    waiting, sent = look(waiting, ARRIVED)  # Whatever it was is over.
    assert sent == ""
    assert look(waiting.resume(0), ARRIVED)[1] == "7"


def test_an_alarm_that_held_the_queue_is_said_to_be_over_when_it_is() -> None:
    waiting, low = queue(7), Alarm(LOW_BATTERY, "", 0.0)
    for alarms, said in (
        ([low], "low battery"),
        ([low._replace(until=1.0, state=AlarmState.RETURNED)], "was: low battery"),
        ([], "was: low battery"),
        ([low], "low battery"),
    ):
        waiting, sent = look(waiting, ARRIVED, alarms)
        assert (sent, waiting.hold_reason) == ("", said)


def test_one_stop_holds_the_queue_as_a_stop_whatever_is_heard_first() -> None:
    aborted = Snapshot(file=ARCHO, goal=ended(0, Phase.ABORTED))
    stopped = aborted._replace(motion=Motion(stopped=True))
    for seen, stops in (([aborted, stopped], 0), ([stopped, aborted], 0), ([aborted], 1)):
        waiting = queue(7)
        for snapshot in seen:
            waiting, sent = look(waiting, snapshot, (), stops)
            assert sent == ""
        assert waiting.hold_reason == "STOP"


def test_it_goes_on_until_all_are_driven_or_held() -> None:
    sent = GoalQueue().submit([target(0), target(7)], Snapshot(file=ARCHO))
    accepted = sent.hand_over().answered(YES)
    aborted = Snapshot(file=ARCHO, goal=ended(0, Phase.ABORTED))
    held, _ = look(accepted, aborted)
    queues = (GoalQueue(), sent, accepted, held, held.resume(0), held.skip())
    assert [queue.is_going for queue in queues] == [False, True, True, False, True, False]
    only = GoalQueue().submit([target(0)], Snapshot(file=ARCHO)).hand_over()
    assert only.is_going
    assert only.answered(YES).is_going
    assert not look(only.answered(YES), ARRIVED)[0].is_going


def test_an_alarm_neither_takes_the_place_of_another_reason_nor_holds_once_acknowledged() -> None:
    refused = queue(7)._replace(underway=())._hold("refused")
    held, _ = look(refused, ARRIVED, [Alarm(LOW_BATTERY, "", 0.0)])
    assert held.hold_reason == "refused"
    going, sent = look(queue(7), ARRIVED)
    assert (going.hold_reason, sent) == ("", "7")
    for name, sent in ((LOW_BATTERY, "7"), (CONTACT_LOST, "")):  # But a lost contact does.
        seen = Alarm(name, "", 0.0, AlarmState.ACKNOWLEDGED)
        assert look(queue(7), ARRIVED, [seen])[1] == sent


def running(number: int, *, mine: bool) -> Goal:
    return Goal(SHELF, {"shelf_number": 1}, Phase.MOVING, 0.0, 0.0, mine=mine, number=number)


def test_ours_on_its_way_comes_before_another_clients_until_it_is_seen_or_refused() -> None:
    others = Snapshot(file=ARCHO, goal=ended(3), history=(ended(3),))
    sent = GoalQueue().submit([target(12)], others)
    others = others._replace(goal=running(5, mine=False))
    assert GoalQueue().running_goal(others) == others.goal
    ours = sent.running_goal(others)
    assert ours is not None
    assert (ours.name, ours.phase) == ("shelf 12", Phase.SENT)
    seen = Snapshot(goal=running(6, mine=False), history=(running(7, mine=True),))
    assert sent.running_goal(seen) == seen.goal
    refused = sent.hand_over().answered(Outcome(Code.REFUSED, "no"))
    assert refused.running_goal(others) == others.goal


# The rules of the queue of goals one by one: numbers, answers, who leaves, and what holds it.

SHELL = Requester("SHELL", "pid 4711")
SHELL.waits = True
NOBODY = Snapshot()
REFUSED, SILENT = Outcome(Code.REFUSED, "no"), Outcome(Code.TIMEOUT, "no answer in 5 s")
STOPPED = Outcome(Code.HELD, "not sent")
RESTORED = GoalQueue().restore([target(1), target(2)])


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


# Its way.


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
    held = GoalQueue().restore([target(1)])._replace(todo=())  # It keeps its reason.
    after = held.submit([target(3)], NOBODY)._replace(todo=()).hand_over().answered(STOPPED)
    told = [(QueueEffect.SETTLE, "3", "held: 3 (restart)"), (QueueEffect.ANSWER, "3", "not sent")]
    assert (done(after), after.hold_reason) == (told, "restart")
    after = typed(1).hand_over().leave(SHELL).answered(STOPPED)
    over = [(what, "1", NEVER_LEFT) for what in (QueueEffect.SETTLE, QueueEffect.ANSWER)]
    assert (done(after), after.waiting) == (over, ())


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


def test_a_list_is_held_by_what_fails_or_a_later_refusal() -> None:
    second = queue(7, 3).seen(ARRIVED, 0.0, 0).hand_over()
    for after, waiting, reason in (
        (answered(SILENT, 1, 2), "2", "no answer"),
        (answered(Outcome(Code.CANCELLED, ""), 1, 2), "2", "cancelled"),
        (second.answered(REFUSED), "3", "refused"),
        (RESTORED.resume(0).seen(NOBODY, 0.0, 0).hand_over().answered(REFUSED), "2", "refused"),
    ):
        assert ([goal.text for goal in after.waiting], after.hold_reason) == ([waiting], reason)


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
    ours = typed(1, 2, by=YOU)
    assert ours.leave(SHELL) == ours
    assert GoalQueue().leave(SHELL) == GoalQueue()


# What is seen.


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
