"""A goal as a machine: every rule about it, without I/O.

`TrackedGoal` is a state; each method is an event, takes the time with it, and returns the next
state, whose `todo` is what is to be sent now. PHASES is the table of the phases; the methods decide
which event of it has happened.

The end of a wait ends no goal: without an answer it is UNKNOWN, without news LOST, until its server
tells how it ended or that it does not know it. Only if its node has left is it over without such a
report (GONE). An ended goal changes no more.

Times are monotonic seconds. Whether a STOP makes the goal void is counted elsewhere, by any thread,
and comes in with the events that it matters to.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import Enum, auto
from typing import Any, NamedTuple

from archo_tui.base.safe_text import harmless
from archo_tui.robot.messages.period import Period
from archo_tui.robot.messages.text import one_line
from archo_tui.robot.messages.values import as_received, number, read, text_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import RUNNING, Goal, Phase
from archo_tui.robot.state.graph import not_offered
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.stop.gate import NEVER_LEFT
from archo_tui.robot_file.model import GoalKind, MessageField

FARTHEST = 1e6  # A larger remainder is not a reading.
# All in seconds.
SILENCE = 3.0  # Without feedback, and three periods of it: a goal that sent some is lost.
NO_PERIOD = 15.0  # Without feedback, if its period is not known: the goal is lost.
ASK_AGAIN = 5.0  # Without news of the goal: its server is asked whether it knows it.
ASK_DOUBTED = 2.0  # The same for a goal that is UNKNOWN or LOST.
RESULT_WAIT = 2.0  # From an end by the status to the end without a result, which tells more.
CANCEL_AGAIN = 2.0  # Between two cancels of a goal behind a STOP.
NOBODY_SERVES = 1.0  # Without a server of its action, and without news: the goal is over.
NEVER_TAKEN = 20.0  # A server that does not know a goal may still accept it so long after.
NEW = 1.0  # A younger goal has just begun.
LONGEST_AGE = 86_400.0  # An older goal has a stamp of another clock.

_NO_REASON = "the robot gave no reason"
_GONE = "the robot may still be moving"
_FORGOTTEN = "the robot no longer knows this goal (was it restarted?)"
_NOT_TAKEN = f"the robot does not know this goal: it did not take it in {NEVER_TAKEN:g} s"


class Event(Enum):
    """An event of a goal that runs."""

    ACCEPTED = auto()  # Its server said yes, in time or late.
    REFUSED = auto()  # Its server said no, or it could not be sent.
    NO_ANSWER = auto()  # Its request was not answered in time.
    FEEDBACK = auto()  # Feedback of it came.
    SAYS_CANCELING = auto()  # Its status says that it is being cancelled.
    CANCEL = auto()  # Its cancel leaves.
    CANCEL_FAILED = auto()  # It was rejected, or not answered, and no other one is awaited.
    SILENT = auto()  # Nothing was heard of it, or of the robot, for too long.
    HEARD = auto()  # The robot is heard again, but not the goal.
    ARRIVED = auto()  # Its server says that it succeeded.
    CANCELLED = auto()  # Its server says that it was cancelled.
    ABORTED = auto()  # Its server says that it was aborted, or does not know it any more.
    DISPUTED = auto()  # Its status and its result differ.
    NODE_LEFT = auto()  # Its node has left: nobody will tell how it ended.


_S, _M, _C, _U, _L = RUNNING
_BEFORE = None  # The phase before the cancel.
PHASES: Mapping[Event, tuple[Phase | None, ...]] = {
    # From:               SENT MOVING CANCELLING UNKNOWN LOST
    Event.ACCEPTED:       (_M, _M, _M, _M, _M),
    Event.REFUSED:        (Phase.REFUSED, _M, _C, Phase.REFUSED, _L),
    Event.NO_ANSWER:      (_U, _M, _C, _U, _L),
    Event.FEEDBACK:       (_S, _M, _C, _M, _M),
    Event.SAYS_CANCELING: (_S, _C, _C, _U, _L),
    Event.CANCEL:         (_S, _C, _C, _C, _C),
    Event.CANCEL_FAILED:  (_S, _M, _BEFORE, _U, _L),
    Event.SILENT:         (_S, _L, _L, _U, _L),
    Event.HEARD:          (_S, _M, _C, _U, _U),
    Event.ARRIVED:        (Phase.ARRIVED,) * 5,
    Event.CANCELLED:      (Phase.CANCELLED,) * 5,
    Event.ABORTED:        (Phase.ABORTED,) * 5,
    Event.DISPUTED:       (Phase.DISPUTED,) * 5,
    Event.NODE_LEFT:      (Phase.GONE,) * 5,
}  # fmt: skip


class GoalEffect(Enum):
    """A thing to be sent now."""

    ASK = auto()  # A question for the result, in place of an earlier one.
    CANCEL = auto()  # Its cancel, as an operator would ask for it.
    CANCEL_UNASKED = auto()  # Its cancel, behind a STOP: no phase tells it.
    CANCEL_ENDED = auto()  # Its cancel: it was accepted after its end.


class TrackedGoal(NamedTuple):
    """A goal from its request, or from when it was found, to its end."""

    goal: Goal  # What the operator is shown of it.
    turn: int = 0  # When it was sent, or found: a STOP with a later turn is meant for it.
    todo: tuple[GoalEffect, ...] = ()  # What is to be sent now; whoever sends it takes it out.
    is_cancelled: bool = False  # The operator cancelled it before it was known to be accepted.
    must_not_run: bool = False  # It is cancelled since it was accepted too late.
    before: Phase = Phase.MOVING  # The cancel; CANCELLING if the server is known to carry it out.
    awaited: int = 0  # Cancels that the phase tells, and that have not been answered yet.
    cancelled_unasked: float = -math.inf
    asked: float = -math.inf  # When its result was last asked for.
    questions: int = 0  # For its result, so far.
    period: Period = Period()  # Of its feedback.
    unserved: float | None = None  # Since when no server was found.
    ended_as: tuple[Event, float] | None = None  # Its end by its status, and when that came.

    @property
    def is_accepted(self) -> bool:
        """True if its server is known to have accepted it, if only by feedback."""
        return self.goal.started is not None

    @property
    def is_running(self) -> bool:
        """True until its end."""
        return self.goal.is_running

    def fire(self, event: Event, now: float, message: str = "", **changes: Any) -> TrackedGoal:
        """Make the step that PHASES tells, and change further fields of the shown goal."""
        goal = self.goal
        if not goal.is_running:
            return self
        phase = PHASES[event][RUNNING.index(goal.phase)] or self.before
        if phase is not goal.phase:
            changes |= {"phase": phase, "lost": now if phase is Phase.LOST else None}
        if phase not in RUNNING:
            changes |= {"message": harmless(message), "ended": now}
        return self._replace(goal=goal._replace(**changes)) if changes else self

    # Its request.

    def leaving(self, now: float, turn: int, goal_number: int) -> TrackedGoal:
        """Take down that its request leaves now."""
        return self._replace(goal=self.goal._replace(sent=now, number=goal_number), turn=turn)

    def refused_late(self, now: float) -> TrackedGoal:
        """Take a refusal; while the goal is SENT it is in time, and its reason is waited for."""
        if self.goal.phase is Phase.SENT:
            return self
        return self.fire(Event.REFUSED, now, "refused (the answer came late)")

    def accepted(self, now: float, *, is_void: bool) -> TrackedGoal:
        """Take the yes of its server, in time or later, and cancel a goal that is not wanted."""
        if not self.is_running:
            is_wanted = self.is_accepted and not (is_void or self.is_cancelled)
            return self if is_wanted else self._replace(todo=(GoalEffect.CANCEL_ENDED,))
        after = self.fire(Event.ACCEPTED, now, started=now, heard=now)
        return after.ask(now).cancelled_if_unwanted(is_void=is_void)

    def cancelled_if_unwanted(self, *, is_void: bool) -> TrackedGoal:
        """Have a moving goal cancelled, once, if a STOP or a cancel came before its acceptance."""
        is_unwanted = is_void or self.is_cancelled
        if not is_unwanted or self.must_not_run or self.goal.phase is not Phase.MOVING:
            return self
        return self._replace(must_not_run=True, todo=(*self.todo, GoalEffect.CANCEL))

    # Its cancel.

    def called_off(self) -> TrackedGoal:
        """Take the operator's cancel: the server may accept the goal later."""
        is_open = self.goal.phase in (Phase.SENT, Phase.UNKNOWN)
        return self._replace(is_cancelled=True) if is_open else self

    def cancelling(self, now: float) -> TrackedGoal:
        """Take down that its cancel leaves; return the same state if it may not leave."""
        after = self.fire(Event.CANCEL, now)
        if after.goal.phase is not Phase.CANCELLING:
            return self
        before = self.before if self.goal.phase is Phase.CANCELLING else self.goal.phase
        goal = after.goal._replace(cancel_asked=now)
        return after._replace(goal=goal, before=before, awaited=self.awaited + 1)

    def cancel_accepted(self) -> TrackedGoal:
        """Take the yes to its cancel: one that fails later changes nothing."""
        if not self.is_running:
            return self
        return self._replace(awaited=self.awaited - 1, before=Phase.CANCELLING)

    def cancel_failed(self, now: float, *, is_rejected: bool) -> TrackedGoal:
        """Return to the phase before; ask about a rejection: its server may not know the goal."""
        if not self.is_running:
            return self
        after = self._replace(awaited=self.awaited - 1)
        if not after.awaited:
            after = after.fire(Event.CANCEL_FAILED, now)
        if after.goal.phase is not self.goal.phase:
            after = after._replace(goal=after.goal._replace(cancel_asked=None))
        return after.ask(now) if is_rejected else after

    def behind_stop(self, turn: int, now: float) -> TrackedGoal:
        """Have it cancelled, if it is from before a STOP, again and again until it ends."""
        is_due = self.turn < turn and now - self.cancelled_unasked > CANCEL_AGAIN
        if not is_due or not self.is_running or self.goal.phase is Phase.SENT:
            return self  # One that is accepted later is void.
        return self.cancelled_with_all(now)._replace(todo=(*self.todo, GoalEffect.CANCEL_UNASKED))

    def cancelled_with_all(self, now: float) -> TrackedGoal:
        """Take down that all goals of its action are cancelled now."""
        return self._replace(cancelled_unasked=now)

    # What is heard.

    def fed(self, feedback: Any, now: float, *, is_void: bool) -> TrackedGoal:
        """Take a feedback message, which also shows that the goal was accepted."""
        goal = self.goal
        if not goal.is_running:
            return self
        changes = feedback_changes(goal, feedback, now)
        started = goal.sent if goal.started is None else goal.started
        after = self._replace(period=self.period.with_message_at(now))
        after = after.fire(Event.FEEDBACK, now, heard=now, started=started, **changes)
        if self.is_cancelled or goal.phase is Phase.UNKNOWN:  # The answer may have been lost.
            return after.cancelled_if_unwanted(is_void=is_void)
        return after

    def reported(self, end: Event | None, now: float, *, is_canceling: bool) -> TrackedGoal:
        """Take its status; an end waits RESULT_WAIT for the result, which tells more."""
        if not self.is_running:
            return self
        if end is not None:
            return self._replace(ended_as=self.ended_as or (end, now))
        after = self.fire(Event.SAYS_CANCELING, now) if is_canceling else self
        if after.goal.phase is not self.goal.phase:
            after = after._replace(goal=after.goal._replace(cancel_asked=now))
        is_confirmed = is_canceling and after.goal.phase is Phase.CANCELLING
        return after._replace(before=Phase.CANCELLING) if is_confirmed else after

    def ask(self, now: float) -> TrackedGoal:
        """Have its result asked for; answers to earlier questions count no more."""
        if not self.is_running:
            return self
        return self._replace(
            asked=now, questions=self.questions + 1, todo=(*self.todo, GoalEffect.ASK)
        )

    def answered(self, question: int, end: Event | None, result: Any, now: float) -> TrackedGoal:
        """Take the answer to a question for its result; without an `end` it does not know it.

        `question` is the value of `questions` when it was asked.
        """
        goal = self.goal
        # One from before the goal was accepted would call it forgotten just as it begins.
        if question != self.questions:
            return self
        if end is None:
            if self.is_accepted:
                return self.forgotten(now)
            # The server may not have decided yet, and is asked again.
            is_over = now - goal.sent > NEVER_TAKEN
            return self.fire(Event.ABORTED, now, _NOT_TAKEN) if is_over else self
        succeeded, has_arrived = getattr(result, "success", None), end is Event.ARRIVED
        if isinstance(succeeded, bool) and succeeded != has_arrived:
            action = "succeeded" if has_arrived else end.name.lower()
            says = "says success" if succeeded else "says not"
            text = f"the action says {action}, its result {says}"
            return self.fire(Event.DISPUTED, now, text, result=result)
        text = _result_text(goal.kind, result)
        is_there = has_arrived and goal.kind.remaining
        changes = {"remaining": 0.0, "unreadable": ""} if is_there else {}
        message = text if text or has_arrived else _NO_REASON
        return self.fire(end, now, message, result=result, **changes)

    def forgotten(self, now: float) -> TrackedGoal:
        """End it since its server does not know it any more."""
        return self.fire(Event.ABORTED, now, _FORGOTTEN)

    def node_left(self, now: float) -> TrackedGoal:
        """End it since its node has left: nobody will tell how it ended."""
        return self.fire(Event.NODE_LEFT, now, _GONE)

    def robot_heard(self, now: float) -> TrackedGoal:
        """Doubt no longer that the robot is there; a LOST goal without feedback is asked about."""
        if self._sends_feedback:
            return self  # Its server may have died while the wheels still report.
        after = self.fire(Event.HEARD, now)
        is_found = after.goal.phase is not self.goal.phase
        return after._replace(asked=-math.inf) if is_found else after

    def period_changed(self, old: object, new: object) -> TrackedGoal:
        """Measure its feedback anew: a parameter of its server (else None) has changed."""
        return self._replace(period=self.period.measured_again(old, new))

    def with_length(self, length: float | None) -> TrackedGoal:
        """Set the length of its way, if it had none, or a guessed one."""
        is_open = self.goal.length is None or self.goal.length_is_guessed
        if length is None or not is_open:
            return self
        return self._replace(goal=self.goal._replace(length=length, length_is_guessed=False))

    def tick(self, now: float, motion: Motion, resumed: float, *, is_served: bool) -> TrackedGoal:
        """Take the time. Call it several times a second.

        Silence counts from `resumed`, when this process last went on after it was suspended:
        messages that came meanwhile may still be unread.
        """
        goal = self.goal
        if not goal.is_running:
            return self
        if self.ended_as is not None and now - self.ended_as[1] > RESULT_WAIT:
            return self.fire(self.ended_as[0], now, _NO_REASON)
        heard = -math.inf if goal.heard is None else goal.heard
        if is_served:
            after = self._replace(unserved=None)
        elif self.unserved is None:
            after = self._replace(unserved=now)
        elif now - max(self.unserved, heard, resumed) >= NOBODY_SERVES:
            return self.node_left(now)
        else:
            after = self
        if self._is_silent(now, motion, resumed):
            after = after.fire(Event.SILENT, now)
        if goal.phase is Phase.SENT or not is_served:
            return after
        if after.goal.phase in (Phase.UNKNOWN, Phase.LOST):
            return after.ask(now) if now - self.asked > ASK_DOUBTED else after
        # The server may have been restarted, while other nodes still send.
        return after.ask(now) if now - max(self.asked, heard) > ASK_AGAIN else after

    @property
    def _sends_feedback(self) -> bool:
        return self.period.last is not None or self.period.known is not None

    def _is_silent(self, now: float, motion: Motion, resumed: float) -> bool:
        """Return True after too long a silence of its feedback, or of the robot's motion."""
        goal, period = self.goal, self.period.seconds
        heard = max(goal.sent if goal.heard is None else goal.heard, resumed)
        is_cancelling = goal.phase is Phase.CANCELLING
        if period is not None and not is_cancelling:
            return now - heard > max(SILENCE, 3 * period)
        # Since ROS 2 Lyrical a server sends no feedback for a goal that it is cancelling.
        last = heard if goal.cancel_asked is None else max(heard, goal.cancel_asked)
        if (self._sends_feedback or is_cancelling) and now - last > NO_PERIOD:
            return True
        longest = max(SILENCE, 3 * (motion.period or 0.0))
        return motion.received is not None and now - max(motion.received, heard) > longest

    # Its end.

    def is_back(self, now: float, *, is_served: bool) -> bool:
        """Return True if feedback shows that a GONE goal runs, and was not merely read late."""
        return is_served and now - (self.goal.ended or now) >= NOBODY_SERVES

    def found_again(self, found: TrackedGoal, *, is_void: bool) -> TrackedGoal:
        """Return a GONE goal that was found again, with what a STOP or a cancel meant for it."""
        before = self.goal
        goal = found.goal._replace(fields=before.fields, mine=before.mine, is_found=True)
        after = found._replace(goal=goal, turn=self.turn, is_cancelled=self.is_cancelled)
        return after.cancelled_if_unwanted(is_void=is_void)


def is_missed(age: float, tracked_for: float, was_reported: bool | None) -> bool:
    """Return True if an ended goal, never tracked, began and ended since the last status message.

    `was_reported` is None without such a message: then a goal that is older than its action is
    tracked ended before the console began.
    """
    return age <= tracked_for if was_reported is None else not was_reported


def found(
    kind: GoalKind,
    phase: Phase,
    age: float,  # Since its server accepted it, by the robot's clock.
    now: float,
    turn: int,
    goal_number: int,
    *,
    is_first: bool = True,
) -> TrackedGoal:
    """Return a goal of another client, as it is tracked from now on."""
    begun = now - age if 0 <= age <= LONGEST_AGE else now
    goal = Goal(
        *(kind, {}, phase, begun, 0.0),
        heard=now,
        started=begun,
        cancel_asked=now if phase is Phase.CANCELLING else None,
        mine=False,
        number=goal_number,
        is_found=is_first and not 0 <= age < NEW,
    )
    return TrackedGoal(goal, turn, before=phase).ask(now)


def refusal(
    goal: TrackedGoal, ours: Goal | None, *, is_served: bool, has_ended: bool
) -> Outcome | None:
    """Return why a goal is not sent beside `ours`, which runs; None if it may leave."""
    if goal.is_cancelled:
        return Outcome(Code.CANCELLED, NEVER_LEFT)
    if ours is not None and ours.phase in (Phase.UNKNOWN, Phase.LOST):
        doubt = f"nothing is heard of the goal to {ours.name}"
        return Outcome(Code.REFUSED, f"{doubt}: cancel it, or wait until the robot is heard")
    if ours is not None:
        return Outcome(Code.REFUSED, "a goal is already running: cancel it first")
    if not is_served:
        return Outcome(Code.NOT_OFFERED, not_offered(goal.goal.kind.action))
    return Outcome(Code.CANCELLED, "not sent: the console ends") if has_ended else None


def end_text(before: Goal, goal: Goal) -> str:
    """Return how a goal ended: `shelf 12 arrived: MESSAGE`; "" if its verb reports that."""
    if goal.phase is Phase.REFUSED and before.phase is Phase.SENT:
        return ""
    word, message = goal.word.lower(), goal.message.lower()
    if word in message and goal.name.lower() in message:
        return goal.message
    return f"{goal.name} {word}: {goal.message}".rstrip(": ")


def _result_text(kind: GoalKind, result: Any) -> str:
    """Return the robot's message in a result; all fields if the robot file names no message."""
    if kind.message:
        value = read(MessageField(kind.message), result)
        return "" if value is None else text_of(value)
    return one_line(result)


def feedback_changes(goal: Goal, feedback: Any, now: float) -> dict[str, Any]:
    """Return the fields of a goal that a feedback message changes, with new values."""
    remaining = goal.kind.remaining
    if remaining is None:
        return {"feedback": one_line(feedback)}
    value = read(MessageField(remaining.field), feedback)
    left = number(value, 0.0, FARTHEST)
    if left is None:
        return {"unreadable": as_received(value)}
    way = goal.way_with(now, left)
    changes: dict[str, Any] = {"remaining": left, "unreadable": "", "way": way}
    is_guess = goal.length is None or goal.length_is_guessed
    # Without a length, the largest remainder so far stands for it.
    if is_guess and not goal.is_found:
        changes |= {"length": max(left, goal.length or 0.0), "length_is_guessed": True}
    return changes
