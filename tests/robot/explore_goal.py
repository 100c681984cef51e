"""Every state of a goal, breadth first: ours, or another client's that is found."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from types import SimpleNamespace
from typing import Any, NamedTuple

from archo_interfaces.action import MoveToShelf

from archo_tui.robot.goals.machine import Event, GoalEffect, TrackedGoal, found
from archo_tui.robot.messages.period import Period
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.readings import Motion
from tests.robot.exploring import Found, breadth_first, promise
from tests.support.archo import SHELF

NOW = 1000.0
NEVER = -math.inf
SUCCESS = MoveToShelf.Result(success=True, final_message="there")
FEEDBACK = SimpleNamespace(distance_remaining=5.0)


def sent() -> TrackedGoal:
    return TrackedGoal(Goal(SHELF, {"shelf_number": 3}, Phase.SENT, NOW, 0.0), turn=5)


class World(NamedTuple):
    """A goal, and what is known of it besides."""

    goal: TrackedGoal
    is_void: bool = False
    came_from: Phase | None = None  # The phase before a cancel.
    is_confirmed: bool = False  # Its server is known to carry a cancel out.
    spans: tuple[float, ...] = (16.0,)  # s that may pass at once.


def begin(**limits: Any) -> World:
    """Return a world with a goal that was just sent."""
    return World(sent(), **limits)


def _another(world: World) -> World:
    """Another client's goal, which is being cancelled when it is found."""
    goal = found(SHELF, Phase.CANCELLING, 0.0, NOW, 5, 1)._replace(todo=())
    return World(goal, is_confirmed=True, spans=world.spans)


def _age(then: Any, *classes: float) -> Any:
    """Return the time of the oldest class that an age has reached."""
    if then is None:
        return None
    return NOW - max(age for age in (0.0, *classes) if NOW - then >= age)


def normal(world: World) -> World:
    """The world with ages by class, and without what decides nothing any more."""
    state = world.goal
    shown = state.goal._replace(
        time=0.0,
        ended=None,
        lost=None,
        message="",
        result=None,
        remaining=None,
        length=None,
        length_is_guessed=False,
        way=(),
    )
    if not state.is_running:
        shown = shown._replace(sent=NOW, heard=None, cancel_asked=None)
        ended = TrackedGoal(shown, is_cancelled=state.is_cancelled, questions=1)
        return World(ended, world.is_void, spans=world.spans)
    heard = _age(shown.heard, 2.6, 5.2, 16.0)
    shown = shown._replace(
        sent=NOW if heard is not None else _age(shown.sent, 2.6, 16.0, 20.1),
        heard=heard,
        started=None if shown.started is None else NOW,
        cancel_asked=_age(shown.cancel_asked, 16.0),
    )
    period = state.period
    if period.last is not None:
        period = Period(last=NOW, known=0.2 if period.intervals or period.known else None)
    is_cancelling = shown.phase is Phase.CANCELLING
    state = state._replace(
        goal=shown,
        todo=(),
        asked=_age(state.asked, 2.6, 5.2),
        questions=1,
        period=period,
        unserved=_age(state.unserved, 1.0),
        before=state.before if is_cancelling else Phase.MOVING,
        is_cancelled=state.is_cancelled and not state.must_not_run,
    )
    came_from = world.came_from if is_cancelling and not world.is_confirmed else None
    is_confirmed = world.is_confirmed and is_cancelling
    return World(state, world.is_void, came_from, is_confirmed, world.spans)


def _later(state: TrackedGoal, seconds: float, **facts: Any) -> TrackedGoal:
    """The goal after some seconds, in which nothing else happened, at NOW."""
    goal, seconds = state.goal, seconds if state.is_running else 0.0
    times = {name: getattr(goal, name) for name in ("sent", "heard", "started", "cancel_asked")}
    earlier: dict[str, Any] = {
        name: None if at is None else at - seconds for name, at in times.items()
    }
    unserved = None if state.unserved is None else state.unserved - seconds
    state = state._replace(
        goal=goal._replace(**earlier),
        asked=state.asked - seconds,
        unserved=unserved,
    )
    motion = facts.get("motion", Motion())
    return state.tick(NOW, motion, NEVER, is_served=facts.get("is_served", True))


def moves(world: World) -> Iterator[tuple[str, Callable[[World], World]]]:
    """Yield all that can happen next, by its name."""
    if not world.is_void:
        yield "a STOP", lambda world: world._replace(is_void=True)
    if world == normal(begin(spans=world.spans)):
        yield "another's", _another
    for name, after in _events(world):
        yield name, partial(step, name, after)


def _events(world: World) -> Iterator[tuple[str, TrackedGoal]]:
    goal, void = world.goal, world.is_void
    yield "accepted", goal.accepted(NOW, is_void=void)
    yield "refused", goal.fire(Event.REFUSED, NOW)
    yield "refused late", goal.refused_late(NOW)
    yield "no answer", goal.fire(Event.NO_ANSWER, NOW)
    yield "checked", goal.cancelled_if_unwanted(is_void=void)
    yield "feedback", goal.fed(FEEDBACK, NOW, is_void=void)
    yield "says canceling", goal.reported(None, NOW, is_canceling=True)
    yield "called off", goal.called_off()
    if goal.awaited < (2 if goal.goal.phase is Phase.CANCELLING else 1):
        yield "cancel", goal.cancelling(NOW)
    if goal.awaited:
        yield "cancel accepted", goal.cancel_accepted()
        yield "cancel failed", goal.cancel_failed(NOW, is_rejected=False)
        yield "cancel rejected", goal.cancel_failed(NOW, is_rejected=True)
    yield "robot heard", goal.robot_heard(NOW)
    yield "node left", goal.node_left(NOW)
    yield "forgotten", goal.forgotten(NOW)
    for end in (Event.ARRIVED, Event.CANCELLED, Event.ABORTED):
        yield f"result {end.name}", goal.answered(goal.questions, end, None, NOW)
    yield "result disputed", goal.answered(goal.questions, Event.ABORTED, SUCCESS, NOW)
    yield "result not known", goal.answered(goal.questions, None, None, NOW)
    yield "earlier result", goal.answered(goal.questions - 1, Event.ARRIVED, None, NOW)
    silent = Motion(received=NOW - 4.0)
    for seconds in world.spans:
        yield f"{seconds} s", _later(goal, seconds)
        yield f"{seconds} s without motion", _later(goal, seconds, motion=silent)
        yield f"{seconds} s without server", _later(goal, seconds, is_served=False)


# What each of these changes; in other phases it changes none.
CHANGES: dict[str, dict[Phase, Phase]] = {
    "refused": {Phase.SENT: Phase.REFUSED, Phase.UNKNOWN: Phase.REFUSED},
    "refused late": {Phase.UNKNOWN: Phase.REFUSED},  # In time, its reason is waited for.
    "no answer": {Phase.SENT: Phase.UNKNOWN},
    "feedback": {Phase.UNKNOWN: Phase.MOVING, Phase.LOST: Phase.MOVING},
    "says canceling": {Phase.MOVING: Phase.CANCELLING},
    "cancel": dict.fromkeys((Phase.MOVING, Phase.UNKNOWN, Phase.LOST), Phase.CANCELLING),
    "robot heard": {Phase.LOST: Phase.UNKNOWN},
    **{name: {} for name in ("cancel accepted", "called off", "checked", "earlier result")},
}


def check_phase(name: str, before: TrackedGoal, phase: Phase) -> None:
    """Check the phase to which an event leads."""
    was, seconds = before.goal.phase, name.split()[-1] == "s" or " s without" in name
    if name in CHANGES and not (name == "robot heard" and before.period.last is not None):
        promise(phase is CHANGES[name].get(was, was), f"{name} in {was}")
    if name in ("cancel failed", "cancel rejected") and was is not Phase.CANCELLING:
        promise(phase is was, f"{name} in {was}")
    if seconds and phase not in (was, Phase.GONE):  # Silence tells nothing of any other goal.
        is_lost = was in (Phase.MOVING, Phase.CANCELLING) and phase is Phase.LOST
        promise(is_lost, "silence loses a goal that is driven, and no other")


def step(name: str, after: TrackedGoal, world: World) -> World:
    """Check the step that an event makes, and return the world after it."""
    before, goal = world.goal, after.goal
    if not before.is_running:
        promise(after._replace(todo=()) == before, f"an ended goal never changes: {name}")
        is_wanted = before.is_accepted and not (world.is_void or before.is_cancelled)
        must_cancel = name == "accepted" and not is_wanted
        todo = (GoalEffect.CANCEL_ENDED,) if must_cancel else ()
        promise(after.todo == todo, "one that is accepted after its end is cancelled if unwanted")
        return world
    check_phase(name, before, goal.phase)
    if name == "earlier result":
        promise(after is before, "an answer to an earlier question counts for nothing")
    if after.is_running and (world.is_void or before.is_cancelled):
        was_unknown = before.goal.phase is Phase.UNKNOWN and name == "feedback"
        if name == "accepted" or was_unknown:
            promise(after.must_not_run, "a void goal that is accepted is cancelled")
    is_due = after.must_not_run and not before.must_not_run
    promise((GoalEffect.CANCEL in after.todo) == is_due, "a void goal is cancelled once")
    if name == "cancel":
        is_sent = before.goal.phase is Phase.SENT
        promise((after is before) == is_sent, "a cancel leaves once the goal has an answer")
    if name == "accepted":
        promise(GoalEffect.ASK in after.todo, "an accepted goal's result is asked for")
    came_from, is_confirmed = world.came_from, world.is_confirmed
    if name == "cancel" and before.goal.phase is not Phase.CANCELLING:
        came_from, is_confirmed = before.goal.phase, False
    if name == "cancel accepted" or name == "says canceling":
        is_confirmed = True
    if name in ("cancel failed", "cancel rejected") and before.goal.phase is Phase.CANCELLING:
        stays = after.awaited or is_confirmed
        expected = Phase.CANCELLING if stays else came_from
        promise(goal.phase is expected, "a failed cancel returns to the phase before")
    if before.goal.phase is Phase.CANCELLING and goal.phase in (Phase.SENT, Phase.UNKNOWN):
        promise(name.startswith("cancel"), "a cancel ends by its answer")
    following = World(after, world.is_void, came_from, is_confirmed, world.spans)
    return world if after is before and following == world else following


def check(world: World) -> None:
    """Check what holds in each state."""
    goal = world.goal
    due = goal.behind_stop(goal.turn + 1, NOW)
    may_run = goal.is_running and goal.goal.phase is not Phase.SENT
    promise((due.todo == (GoalEffect.CANCEL_UNASKED,)) == may_run, "cancelled behind a STOP")
    promise(due.goal is goal.goal, "no phase tells a cancel that nobody asked for")
    if goal.goal.phase in (Phase.UNKNOWN, Phase.LOST):
        later = _later(goal, 2.6)
        is_asked = not later.is_running or GoalEffect.ASK in later.todo
        promise(is_asked, "a doubtful goal is asked about")
    if goal.goal.phase is Phase.CANCELLING:
        promise(goal.goal.cancel_asked is not None, "a cancel has its time")


def _key(world: World) -> tuple[object, ...]:
    shown = world.goal.goal
    times = shown.phase, shown.sent, shown.heard, shown.started, shown.cancel_asked
    return (*times, world.goal._replace(goal=None), *world[1:])  # type: ignore[arg-type]


def explore(world: World) -> Found:
    """Visit every state that can be reached, or until a promise is broken."""
    return breadth_first(normal(world), moves, normal, check, _key)


WORLDS: dict[str, dict[str, Any]] = {"16 s": {}, "2.6 or 16 s": {"spans": (2.6, 16.0)}}
