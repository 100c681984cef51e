"""The goals that are wanted here as a machine, from typing to their outcome, without I/O.

A goal waits, or is held until the operator continues; it is on its way until the robot has
answered, and underway until it is seen to end or counts as lost; then it is settled. Each method is
an event and returns the next state, whose `todo` is what is to be done now.

At most one goal is on its way. Anything but an arrival holds the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum, auto
from typing import Any, NamedTuple

from archo_tui.robot.clients import YOU, Requester
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal, Phase, values_text
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.stop.gate import NEVER_LEFT
from archo_tui.robot_file.model import GoalKind

_WAS = "was: "  # Before the name of an alarm that is over, as in the banner.
# Of a list whose first goal ends so, no other goal is driven.
_REFUSALS = (Code.REFUSED, Code.NOT_OFFERED, Code.MISUSE, Code.WATCHING)
_REASONS = {Code.CANCELLED: "cancelled", Code.TIMEOUT: "no answer"}


class QueuedGoal(NamedTuple):
    """A goal that is wanted."""

    kind: GoalKind
    values: Mapping[str, Any]  # By dotted path in the goal message.
    # STOPs before it was typed or the queue continued: see `Stops.total`.
    stop_count: int = 0
    requester: Requester = YOU
    number: int = 0  # Names it in the queue, counted from 1.
    list_number: int = 0  # The same for each goal of one line.
    is_first: bool = False  # Without it the others of its list are not driven.

    @property
    def text(self) -> str:
        """The values for people, as `7` or `x 1.5, y 2`; without values the goal's title."""
        return values_text(self.kind, self.values) or self.kind.title


class QueueEffect(Enum):
    """A thing to be done for a goal."""

    SEND = auto()
    SETTLE = auto()  # Give its outcome to those that wait for its end.
    ANSWER = auto()  # Give the robot's answer to those that wait for it.
    CANCEL = auto()  # Its requester has left, or waits in vain.
    NOTE = auto()  # Write an event.


class Deed(NamedTuple):
    """A thing to be done, with what it takes."""

    do: QueueEffect
    goal: QueuedGoal | None = None
    outcome: Outcome | None = None
    ended: Goal | None = None  # As the robot ended it.
    text: str = ""


class Holding(NamedTuple):
    """The alarms that hold every queue."""

    now: str = ""  # The first one that does; "" if none does.
    active: frozenset[str] = frozenset()  # All whose cause is there, also acknowledged ones.


class OnItsWay(NamedTuple):
    """A goal without the robot's answer."""

    goal: QueuedGoal
    before: int  # The number of the newest goal that was known before it.
    waited: bool  # It comes from the queue: its verb returned long before.
    is_handed_over: bool = False  # To the robot's side: only a request can cancel it from now on.
    is_called_off: bool = False  # Before that: it never leaves.
    is_abandoned: bool = False  # Its requester has left.


class GoalQueue(NamedTuple):
    """The goals that are wanted and not settled yet."""

    waiting: tuple[QueuedGoal, ...] = ()  # The next one first.
    hold_reason: str = ""  # Why they are held, in words; "" if they are not.
    coming: OnItsWay | None = None
    # The goals that the robot accepted, each with the newest goal's number before it.
    underway: tuple[tuple[QueuedGoal, int], ...] = ()
    todo: tuple[Deed, ...] = ()  # What is to be done now; whoever does it takes it out.
    alarm: str = ""  # The alarm that holds the queue; its name changes when it is over.
    continued: str = ""  # Why it was held until the operator continued, just now.
    ended: frozenset[int] = frozenset()  # The numbers of the ended goals that were shown last.
    submitted: int = 0  # Goals so far.

    @property
    def is_going(self) -> bool:
        """True if a goal is on its way or underway, or goals wait and are not held."""
        is_driving = self.coming is not None or bool(self.underway)
        return is_driving or (bool(self.waiting) and not self.hold_reason)

    def running_goal(self, snapshot: Snapshot) -> Goal | None:
        """Return our goal on its way, else any client's running goal in the snapshot, else None."""
        sent = [*self.underway]
        if self.coming is not None:
            sent.append((self.coming.goal, self.coming.before))
        for goal, before in sent:
            if ours_since(snapshot, before) is None:  # It is not shown yet.
                return Goal(goal.kind, goal.values, Phase.SENT, 0.0, 0.0)
        return snapshot.running_goal

    def _is_free(self, snapshot: Snapshot) -> bool:
        """Return True if the next goal may be sent: none runs, and none is on its way."""
        return self.coming is None and self.running_goal(snapshot) is None

    # What the operator or a client does.

    def submit(
        self,
        goals: Sequence[QueuedGoal],
        snapshot: Snapshot,
        *,
        may_send: bool = True,
        is_stopped: bool = False,
    ) -> GoalQueue:
        """Take the goals of one line.

        If no goal runs or is on its way, the first one goes before all that wait, also if these are
        held. If one runs and the robot `is_stopped`, they are held at once.
        """
        first = self.submitted + 1
        goals = [
            goal._replace(number=first + place, list_number=first, is_first=place == 0)
            for place, goal in enumerate(goals)
        ]
        after = self._replace(submitted=self.submitted + len(goals))
        if may_send and self._is_free(snapshot):
            after = after._send(goals.pop(0), snapshot, waited=False)
            is_stopped = False  # The answer to the first one says what comes of the others.
        after = after._replace(waiting=(*after.waiting, *goals))._tell_held(goals)
        return after._hold("STOP") if is_stopped else after

    def resume(self, stop_count: int) -> GoalQueue:
        """Continue; the goals count as typed now, so that only a later STOP holds them."""
        waiting = tuple(goal._replace(stop_count=stop_count) for goal in self.waiting)
        reason = self.hold_reason
        return self._replace(waiting=waiting, hold_reason="", alarm="", continued=reason)

    def skip(self) -> GoalQueue:
        """Leave out the next goal; there must be one."""
        goal, *rest = self.waiting
        outcome = Outcome(Code.CANCELLED, f"left out of the queue: {goal.text}")
        return self._replace(waiting=tuple(rest))._settle(goal, outcome)._emptied()

    def call_off(self) -> GoalQueue:
        """Cancel the goal on its way, unless it is handed over: then only a request does that."""
        if self.coming is None or self.coming.is_handed_over:
            return self
        return self._replace(coming=self.coming._replace(is_called_off=True))

    def leave(self, requester: Requester) -> GoalQueue:
        """Take out what a requester that has gone wanted; its goal on its way is cancelled."""
        after = self.take_out(requester)
        if after.coming is None or after.coming.goal.requester is not requester:
            return after
        return after._replace(coming=after.coming._replace(is_abandoned=True)).call_off()

    def take_out(self, requester: Requester) -> GoalQueue:
        """Take a requester's goals out of the queue: nobody waits for them any more."""
        reason = "nobody waits for it any more"
        return self._without(lambda goal: goal.requester is requester, reason)[0]

    def restore(self, goals: Sequence[QueuedGoal]) -> GoalQueue:
        """Take over the goals that waited before a restart; they are held."""
        after = self
        for goal in goals:  # Which of them were one list is not known any more.
            after = after.submit([goal], Snapshot(), may_send=False)
        return after._hold("restart")

    # On the way.

    def hand_over(self) -> GoalQueue:
        """Take down that the goal on its way is handed over to the robot's side."""
        assert self.coming is not None
        return self._replace(coming=self.coming._replace(is_handed_over=True))

    def drop(self) -> GoalQueue:
        """Settle a goal on its way that its frontend ended before sending."""
        if self.coming is None or self.coming.is_handed_over:
            return self
        return self.call_off().answered(Outcome(Code.CANCELLED, NEVER_LEFT))

    def lose(self) -> GoalQueue:
        """Forget the goal on its way: the screen ends, and the next one learns of it as it runs."""
        return self._replace(coming=None)

    def answered(self, outcome: Outcome) -> GoalQueue:
        """Take the robot's answer to the goal on its way, or that it was not sent."""
        assert self.coming is not None
        coming, goal = self.coming, self.coming.goal
        after = self._replace(coming=None)
        if outcome.code is Code.HELD:  # By a STOP: it was not sent, and waits again.
            if not coming.is_abandoned:
                after = after._replace(waiting=(goal, *after.waiting))._hold("STOP")
                return after._tell_held([goal])._do(Deed(QueueEffect.ANSWER, goal, outcome))
            outcome = Outcome(Code.CANCELLED, NEVER_LEFT)
        if outcome.ok:
            after = after._replace(underway=(*after.underway, (goal, coming.before)))
        else:
            if goal.is_first and outcome.code in _REFUSALS:
                after, rest = after._without(
                    lambda other: other.list_number == goal.list_number, f"{goal.text} was refused"
                )
                if rest:
                    outcome = outcome._replace(text=f"{outcome.text}; not driven either: {rest}")
            after = after._hold(_REASONS.get(outcome.code, "refused"))._settle(goal, outcome)
        after = after._do(Deed(QueueEffect.ANSWER, goal, outcome))
        # Without an answer the robot may still accept it, and nobody would wait for its end then.
        is_doubtful = outcome.code is Code.TIMEOUT and goal.requester.waits
        may_run = outcome.ok or outcome.code is Code.TIMEOUT
        if is_doubtful or (may_run and coming.is_abandoned):
            after = after._do(Deed(QueueEffect.CANCEL, goal))
        return after

    # What is seen of the robot.

    def seen(
        self,
        snapshot: Snapshot,
        now: float,
        stop_count: int,
        holding: Holding = Holding(),  # noqa: B008 - immutable
    ) -> GoalQueue:
        """Settle what has ended, hold the queue if it is time, or send the goal that is due.

        It is held if the last goal, whoever sent it, ended without arriving, the robot is stopped,
        a STOP was read since a goal was typed (`stop_count` were read by now), or by an alarm.
        """
        ended = [goal for goal in _goals_shown(snapshot) if not goal.is_running]
        after = self._settled(snapshot, now)
        after = after._replace(ended=frozenset(goal.number for goal in ended))
        failures = [
            goal.word.lower()
            for goal in ended
            if goal.number not in self.ended and goal.phase is not Phase.ARRIVED
            # Ours may have ended beside another client's, which is shown and runs on.
            if goal.mine or goal is snapshot.goal
        ]
        if snapshot.is_stopped or any(goal.stop_count < stop_count for goal in after.waiting):
            # Also over the reason of a goal that this STOP ended, which may be heard of before it.
            after = after._hold("STOP")
            after = after._replace(hold_reason="STOP" if after.waiting else "", alarm="")
        elif failures:
            after = after._hold(failures[0])
        elif holding.now and after.waiting and not after.hold_reason:
            after = after._hold(holding.now)._replace(alarm=holding.now)
        if after.alarm and after.hold_reason:
            is_active = after.alarm in holding.active
            after = after._replace(hold_reason=after.alarm if is_active else _WAS + after.alarm)
        if after.waiting and not after.hold_reason and after._is_free(snapshot):
            first, *rest = after.waiting
            after = after._replace(waiting=tuple(rest))._send(first, snapshot, waited=True)
        return after._replace(continued="")

    def _settled(self, snapshot: Snapshot, now: float) -> GoalQueue:
        after = self
        for pair in self.underway:
            ended = ours_since(snapshot, pair[1])
            outcome = None if ended is None else ended.outcome_at(now)
            if outcome is not None:
                left = tuple(other for other in after.underway if other is not pair)
                deed = Deed(QueueEffect.SETTLE, pair[0], outcome, ended)
                after = after._replace(underway=left)._do(deed)
        return after

    # Steps.

    def _do(self, deed: Deed) -> GoalQueue:
        return self._replace(todo=(*self.todo, deed))

    def _settle(self, goal: QueuedGoal, outcome: Outcome) -> GoalQueue:
        return self._do(Deed(QueueEffect.SETTLE, goal, outcome))

    def _send(self, goal: QueuedGoal, snapshot: Snapshot, *, waited: bool) -> GoalQueue:
        before = max((goal.number for goal in _goals_shown(snapshot)), default=0)
        after = self._replace(coming=OnItsWay(goal, before, waited))
        return after._do(Deed(QueueEffect.SEND, goal))._emptied()

    def _hold(self, reason: str) -> GoalQueue:
        """Hold what waits, and tell it; a queue that is held already keeps its reason."""
        if not self.waiting or self.hold_reason:
            return self
        texts = ", ".join(goal.text for goal in self.waiting)
        after = self._replace(hold_reason=reason, continued="")
        if reason != self.continued.removeprefix(_WAS):  # Else it was told, and is held on.
            after = after._do(Deed(QueueEffect.NOTE, text=f"queue held: {texts} ({reason})"))
        return after._tell_held(after.waiting)

    def _tell_held(self, goals: Sequence[QueuedGoal]) -> GoalQueue:
        after = self
        for goal in goals if self.hold_reason else ():
            text = f"held: {goal.text} ({self.hold_reason})"
            after = after._settle(goal, Outcome(Code.HELD, text))
        return after

    def _without(
        self, is_meant: Callable[[QueuedGoal], bool], reason: str
    ) -> tuple[GoalQueue, str]:
        """Take goals out of the queue, with an event; return their texts as well."""
        removed = list(filter(is_meant, self.waiting))
        texts = ", ".join(goal.text for goal in removed)
        after = self._replace(waiting=tuple(goal for goal in self.waiting if not is_meant(goal)))
        for goal in removed:
            text = f"taken out of the queue: {goal.text}"
            after = after._settle(goal, Outcome(Code.CANCELLED, text))
        if removed:
            after = after._do(
                Deed(QueueEffect.NOTE, text=f"left out of the queue: {texts} ({reason})")
            )
        return after._emptied(), texts

    def _emptied(self) -> GoalQueue:
        """Hold no longer if nothing waits."""
        return self if self.waiting else self._replace(hold_reason="", alarm="")


def ours_since(snapshot: Snapshot, before: int) -> Goal | None:
    """Return the first goal of this console with a number over `before`; None if none is shown."""
    ours = [goal for goal in _goals_shown(snapshot) if goal.mine and goal.number > before]
    return min(ours, key=lambda goal: goal.number, default=None)


def _goals_shown(snapshot: Snapshot) -> list[Goal]:
    return [goal for goal in (snapshot.goal, *snapshot.history) if goal is not None]
