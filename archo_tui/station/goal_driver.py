"""The sending of goals, one after the other, their cancelling, and their outcomes."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from archo_tui.clock import Clock
from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.requester import YOU, Requester, current_requester, on_behalf_of
from archo_tui.robot.state import Goal, Snapshot
from archo_tui.robot.stop.gate import NEVER_LEFT, NOT_SENT
from archo_tui.station.alarms import Alarm
from archo_tui.station.ledger import Ledger
from archo_tui.station.protocols import Frontend
from archo_tui.station.queue import GoalQueue, QueuedGoal

if TYPE_CHECKING:
    from archo_tui.robot.robot import Robot

MAX_QUEUED_GOALS = 1000
CALLED_OFF = "called off"
# Of a list whose first goal ends so, no other goal is driven.
_REFUSALS = (Code.REFUSED, Code.NOT_OFFERED, Code.MISUSE, Code.WATCHING)
# Attempts to cancel the goal of a requester that has left. Each waits for its answer.
_CANCEL_ATTEMPTS = 3


class GoalDriver:
    """The sender of goals: it keeps them in order, and gives each its outcome.

    Used on the event loop of the frontend only.

    Attributes:
        queue: The goals that wait.
        ledger: The requests without an answer.
        frontend: The frontend that runs the sending; None before the first one: no goal may be
            driven then.
    """

    def __init__(
        self,
        robot: Robot,
        clock: Clock,
        on_changed: Callable[[], object],
        on_ended: Callable[[QueuedGoal, Goal], None],
    ) -> None:
        """Create a driver without goals.

        Args:
            robot: The robot, through the console's node.
            clock: Decides whether a goal that is not seen any more is lost.
            on_changed: Called after the queue has changed; calls `update` in its turn.
            on_ended: Called with each goal that the robot accepted from here and that has ended, as
                it was sent and as it ended.
        """
        self.ledger = Ledger()
        self.queue = GoalQueue(self.ledger)
        self.frontend: Frontend | None = None
        self._robot, self._clock = robot, clock
        self._on_changed, self._on_ended = on_changed, on_ended
        self._snapshot = Snapshot()
        self._last_hold_reason = ""
        self._list_numbers = itertools.count(1)
        # The goals that the robot accepted, each with the number of the newest goal before it.
        self._underway: list[tuple[QueuedGoal, int]] = []

    def update(self, snapshot: Snapshot, alarms: Iterable[Alarm]) -> None:
        """Report the goals that have ended, and send the goal that is due, if there is one.

        When the queue becomes held, an event is written. The goals in a held queue get the outcome
        HELD.

        Args:
            snapshot: The state of the robot from now on.
            alarms: All alarms that are on the board.
        """
        self._snapshot = snapshot
        self._settle_ended_goals()
        self._send_due_goal(alarms)

    @property
    def busy_reason(self) -> str:
        """The reason why an assistant cannot ask for a goal now; "" if it can.

        It cannot while the robot is stopped, or a goal runs, is being sent or waits in the queue.
        """
        snapshot = self._snapshot
        if snapshot.is_stopped:
            return "the robot is stopped"
        if snapshot.running_goal is not None or self._underway:
            return "another goal runs"
        if self.queue.waiting:
            return "goals wait in the queue"
        return "another goal is being sent" if self.queue.is_going else ""

    def goal_of(self, requester: Requester) -> Goal | None:
        """Return the present state of a requester's goal that the robot has accepted and not ended.

        Returns:
            The oldest such goal; None if there is none, or no snapshot shows it yet.
        """
        befores = [before for goal, before in self._underway if goal.requester is requester]
        return self._goal_after(befores[0]) if befores else None

    def drive(self, goals: Sequence[QueuedGoal]) -> asyncio.Future[Outcome]:
        """Send goals one after the other, behind a goal that runs or is being sent.

        If none runs, the first is sent at once, even before goals that wait; the others wait behind
        these. Their requester is the current one (see robot/requester.py). Unless it is YOU, a
        future of the outcome of each goal is added to the requester's `ends`. Called on the event
        loop.

        Args:
            goals: At least one.

        Returns:
            A future of the robot's answer to the first goal; ACCEPTED at once if that goal waits in
            the queue. CANCELLED if a STOP or a cancel came before it was sent. CANCELLED if the
            requester has left, and REFUSED if the goals, the first included, and those that wait
            are more than MAX_QUEUED_GOALS: no goal is sent or queued then.
        """
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[Outcome] = loop.create_future()
        if current_requester().has_left:
            answer.set_result(Outcome(Code.CANCELLED, CALLED_OFF))
            return answer
        if len(self.queue.waiting) + len(goals) > MAX_QUEUED_GOALS:
            text = f"more than {MAX_QUEUED_GOALS} goals would wait"
            answer.set_result(Outcome(Code.REFUSED, text))
            return answer
        stop_count, requester = self._robot.stops.count_when_typed, current_requester()
        number = next(self._list_numbers)
        goals = [g._replace(list_number=number, is_first=g is goals[0]) for g in goals]
        if requester is not YOU:
            goals = [goal._replace(requester=requester, end=loop.create_future()) for goal in goals]
            requester.ends += [goal.end for goal in goals if goal.end is not None]
        goals = [goal._replace(stop_count=stop_count) for goal in goals]
        first = self.queue.submit(goals, self._snapshot)
        if first is None:
            held = f", held: {self.queue.hold_reason}" if self.queue.hold_reason else ""
            answer.set_result(Outcome(Code.ACCEPTED, f"queued{held}"))
        else:
            self._start_sending(first, answer)
        self._on_changed()
        return answer

    def resume(self) -> Outcome:
        """Resume a held queue, unless a STOP was read after the command; send the goal that is due.

        The attempt becomes an event.

        Returns:
            DONE, also if the queue was not held; CANCELLED if a STOP was read after the command;
            REFUSED if the queue is held again at once, because the cause is not over.
        """
        gate = self._robot.stops.gate()
        outcome = Outcome(Code.CANCELLED, NOT_SENT) if gate.is_shut else Outcome(Code.DONE, "")
        if outcome.ok:
            self.queue.resume(gate.count_when_typed)
            self.queue.waiting = list(map(_with_pending_end, self.queue.waiting))
            self._on_changed()
            if self.queue.hold_reason:
                outcome = Outcome(Code.REFUSED, f"still held: {self.queue.hold_reason}")
        more = f": {outcome.text}" if outcome.text else ""
        record = AuditRecord("continue", {}, outcome.code)
        self._robot.note("YOU", "console", f"continue the queue{more}", audit_record=record)
        return outcome

    def skip(self) -> Outcome:
        """Remove the next goal of the queue, which must not be empty, and write an event.

        Returns:
            DONE with the goal in words; the outcome of the goal itself is CANCELLED.
        """
        goal = self.queue.skip_next()
        text = f"left out of the queue: {goal.text}"
        _set_outcome(goal, Outcome(Code.CANCELLED, text))
        self._robot.note("YOU", "console", text, audit_record=AuditRecord("skip", {}, Code.DONE))
        self._on_changed()
        return Outcome(Code.DONE, f"left out: {goal.text}")

    async def cancel(self, *, another: bool = False) -> Outcome:
        """Cancel the goal of this console, on its way or running, and return the robot's answer.

        A goal that has not left the console is never sent: ACCEPTED without a request. Goals in the
        queue stay there.

        Args:
            another: True to cancel the running goal of another client. A goal of this console that
                has not left is cancelled instead.
        """
        if self.ledger.goal is None or self.ledger.is_handed_over:
            return await self._robot.cancel(another=another)
        self.ledger.is_cancelled = True
        outcome = Outcome(Code.ACCEPTED, NEVER_LEFT)
        record = AuditRecord("cancel", {}, outcome.code)
        self._robot.note("YOU", "console", f"cancel: {outcome.text}", audit_record=record)
        return outcome

    async def call_off(self, requester: Requester) -> None:
        """Remove the goals of a requester that has left from the queue, and cancel its running one.

        If three attempts do not cancel the goal, an event says that it may still run.
        """
        self.take_out(requester)
        for _ in range(_CANCEL_ATTEMPTS):
            if not self._has_goal_underway(requester):
                return
            with on_behalf_of(requester):
                outcome = await self.cancel()
            if outcome.ok:
                return
        if self._has_goal_underway(requester):
            text = f"the goal of {requester.source}, which has left, may still run: {outcome.text}"
            self._robot.note("ERROR", "console", text)

    def take_out(self, requester: Requester) -> None:
        """Remove the goals of a requester from the queue, since nobody waits for them any more."""
        self._leave_out(lambda goal: goal.requester is requester, "nobody waits for it any more")

    def _leave_out(self, is_meant: Callable[[QueuedGoal], bool], reason: str) -> str:
        """Remove goals from the queue, and write an event if there are any; return their texts."""
        removed = self.queue.remove(is_meant)
        texts = ", ".join(goal.text for goal in removed)
        for goal in removed:
            _set_outcome(goal, Outcome(Code.CANCELLED, f"taken out of the queue: {goal.text}"))
        if removed:
            self._robot.note("WARN", "console", f"left out of the queue: {texts} ({reason})")
            self._on_changed()
        return texts

    @property
    def staying(self) -> str:
        """The goals that stay in the queue when the goal that runs is cancelled, in words."""
        return ", ".join(goal.text for goal in self.queue.waiting if not goal.requester.waits)

    def _has_goal_underway(self, requester: Requester) -> bool:
        return any(goal.requester is requester for goal, _ in self._underway)

    def _goal_after(self, before: int) -> Goal | None:
        """Return the first goal of this console with a number over `before`, or None."""
        snapshot = self._snapshot
        ours = [goal for goal in (snapshot.goal, *snapshot.history) if goal and goal.mine]
        since = [goal for goal in ours if goal.number > before]
        return min(since, key=lambda goal: goal.number, default=None)

    def _settle_ended_goals(self) -> None:
        """Report each accepted goal that has ended or is lost.

        Its requester gets it as `goal`, `on_ended` is called, and its outcome is set.
        """
        for queued, before in list(self._underway):
            goal = self._goal_after(before)
            outcome = None if goal is None else goal.outcome_at(self._clock.monotonic())
            if goal is not None and outcome is not None:
                self._underway.remove((queued, before))
                queued.requester.goal = goal
                self._on_ended(queued, goal)
                _set_outcome(queued, outcome)

    def _send_due_goal(self, alarms: Iterable[Alarm]) -> None:
        """Send the goal of the queue that is due, and write an event when the queue becomes held.

        While it is held, the goals that wait have the outcome HELD.
        """
        due = self.queue.take_due(self._snapshot, alarms, self._robot.stops.count)
        before, self._last_hold_reason = self._last_hold_reason, self.queue.hold_reason
        reason = self.queue.hold_reason
        if reason and not before:
            texts = ", ".join(goal.text for goal in self.queue.waiting)
            self._robot.note("WARN", "console", f"queue held: {texts} ({reason})")
        for goal in self.queue.waiting if reason else ():
            _set_outcome(goal, Outcome(Code.HELD, f"held: {goal.text} ({reason})"))
        if due is not None:
            self._start_sending(due)

    def _start_sending(
        self, goal: QueuedGoal, answer: asyncio.Future[Outcome] | None = None
    ) -> None:
        """Let the frontend send a goal.

        Args:
            goal: The goal, which the ledger has.
            answer: Gets the robot's answer; None for a goal of the queue, which nobody waits for.
        """
        assert self.frontend is not None  # Nothing is due without a frontend.
        before = self.ledger.newest_before
        self.frontend.carry_out(partial(self._send, self.frontend, goal, before, answer))

    async def _send(
        self,
        frontend: Frontend,
        goal: QueuedGoal,
        before: int,
        answer: asyncio.Future[Outcome] | None,
    ) -> None:
        """Send a goal and take in the robot's answer; a STOP puts a goal of the queue back into it.

        A goal that is not accepted holds the queue. A goal that is cancelled in time is not sent.
        If no answer comes in time, the goal is cancelled for a requester that waits or has left;
        one that is accepted is cancelled if the requester has left.

        Args:
            frontend: Shows the answer to a goal of the queue.
            goal: The goal.
            before: The number of the newest goal that was known before this one was sent.
            answer: Gets the robot's answer; None for a goal of the queue.
        """
        is_queued = answer is None
        if self.ledger.is_cancelled:
            outcome = Outcome(Code.CANCELLED, NEVER_LEFT)
        else:
            self.ledger.is_handed_over = True
            try:
                with self._robot.stops.typed_at(goal.stop_count), on_behalf_of(goal.requester):
                    outcome = await self._robot.send(goal.kind, goal.values, queued=is_queued)
            except asyncio.CancelledError:
                # The screen ends. The next one learns of the goal by its snapshot.
                self.ledger.remove_goal()
                raise
        if outcome.code == Code.HELD:
            self.queue.put_back(goal)
        else:
            if goal.is_first and outcome.code in _REFUSALS:
                rest = self._leave_out(
                    lambda other: other.list_number == goal.list_number, f"{goal.text} was refused"
                )
                if rest:
                    outcome = outcome._replace(text=f"{outcome.text}; not driven either: {rest}")
            reasons = {Code.CANCELLED: "cancelled", Code.TIMEOUT: "no answer"}
            self.queue.on_answer(ok=outcome.ok, reason=reasons.get(outcome.code, "refused"))
            if outcome.ok:
                self._underway.append((goal, before))
                self._settle_ended_goals()
                if goal.requester.has_left:  # While the goal was being sent.
                    await self.call_off(goal.requester)
            else:
                _set_outcome(goal, outcome)
        if answer is None:
            frontend.on_goal_answered(goal, outcome)
        elif not answer.done():
            answer.set_result(outcome)
        if outcome.code == Code.TIMEOUT and (goal.requester.waits or goal.requester.has_left):
            # The robot may still accept the goal, and nobody would wait for its end then.
            with on_behalf_of(goal.requester):
                await self.cancel()


def _with_pending_end(goal: QueuedGoal) -> QueuedGoal:
    """Return a resumed goal with a new future as `end` if the hold has set the old one.

    In the requester's `ends` the new future takes the old one's place. Any other goal is returned
    unchanged.
    """
    if goal.end is None or not goal.end.done():
        return goal
    pending = goal.end.get_loop().create_future()
    ends = goal.requester.ends
    ends[:] = [pending if end is goal.end else end for end in ends]
    return goal._replace(end=pending)


def _set_outcome(goal: QueuedGoal, outcome: Outcome) -> None:
    """Set the outcome of a goal, for those that wait for it; a second outcome is ignored."""
    if goal.end is not None and not goal.end.done():
        goal.end.set_result(outcome)
