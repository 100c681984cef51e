"""The queue of goals: what holds it, and what goes on."""

from __future__ import annotations

from typing import Any

import pytest

from archo_tui.robot.goals.queue import GoalQueue, QueuedGoal, QueueEffect
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import OpenStop, Snapshot
from archo_tui.station.alarms import Alarm, AlarmState, holding
from archo_tui.station.conditions import BATTERY_EMPTY, CONTACT_LOST, LOW_BATTERY
from tests.robot.explore_queue import Stage, stage
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


def test_an_alarm_that_was_acknowledged_holds_nothing_but_a_lost_contact_does() -> None:
    for name, sent in ((LOW_BATTERY, "7"), (CONTACT_LOST, "")):
        seen = Alarm(name, "", 0.0, AlarmState.ACKNOWLEDGED)
        assert look(queue(7), ARRIVED, [seen])[1] == sent


def test_the_next_one_waits_until_the_one_before_was_seen_to_end() -> None:
    waiting, sent = look(queue(7, 3), Snapshot(file=ARCHO))  # Accepted, and not seen yet.
    assert sent == ""
    waiting, sent = look(waiting, Snapshot(file=ARCHO, goal=ended(0, Phase.MOVING)))
    assert sent == ""
    waiting, sent = look(waiting, ARRIVED)
    assert sent == "7"
    assert (stage(waiting, 2), stage(waiting, 3)) == (Stage.ON_ITS_WAY, Stage.WAITING)
    assert look(waiting, ARRIVED)[1] == ""
    waiting = waiting.hand_over().answered(YES)
    assert look(waiting, ARRIVED)[1] == ""
    waiting, sent = look(waiting, Snapshot(file=ARCHO, goal=ended(7)))
    assert (sent, stage(waiting, 2)) == ("3", Stage.SETTLED)


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


def test_an_alarm_does_not_take_the_place_of_another_reason() -> None:
    refused = queue(7)._replace(underway=())._hold("refused")
    held, _ = look(refused, ARRIVED, [Alarm(LOW_BATTERY, "", 0.0)])
    assert held.hold_reason == "refused"
    going, sent = look(queue(7), ARRIVED)
    assert (going.hold_reason, sent) == ("", "7")


def test_an_alarm_that_holds_nothing_is_not_named_by_a_later_hold() -> None:
    low = Alarm(LOW_BATTERY, "", 0.0)
    driving, _ = look(queue(), Snapshot(file=ARCHO, goal=ended(0, Phase.MOVING)), [low])
    waiting = driving.submit([target(7)], Snapshot(file=ARCHO, goal=ended(0, Phase.MOVING)))
    held, _ = look(waiting, Snapshot(file=ARCHO, goal=ended(0, Phase.ABORTED)))
    assert held.hold_reason == "aborted"


def test_a_refused_goal_from_before_a_restart_leaves_the_others_held() -> None:
    restored = GoalQueue().restore([target(1), target(2)])
    sent = restored.resume(0).seen(Snapshot(file=ARCHO), 0.0, 0)
    refused = sent.hand_over().answered(Outcome(Code.REFUSED, "no"))
    assert ([goal.text for goal in refused.waiting], refused.hold_reason) == (["2"], "refused")


def test_a_queue_that_is_held_on_is_told_once() -> None:
    held, _ = look(queue(7), ARRIVED._replace(motion=Motion(stopped=True)))
    again = held.resume(0).seen(ARRIVED._replace(motion=Motion(stopped=True)), 0.0, 0)
    assert again.hold_reason == "STOP"
    assert [deed for deed in again.todo if deed.do is QueueEffect.NOTE] == []


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
