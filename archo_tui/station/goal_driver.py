"""The driving of goals for the frontend, by the rules of robot/goals/queue.py."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from archo_tui.base.clock import Clock
from archo_tui.robot.clients import YOU, Requester, current_requester, on_behalf_of
from archo_tui.robot.goals.queue import (
    Deed,
    GoalQueue,
    Holding,
    QueuedGoal,
    QueueEffect,
    ours_since,
)
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.stop.gate import NEVER_LEFT, NOT_SENT

if TYPE_CHECKING:
    from archo_tui.robot.robot import Robot

MAX_QUEUED_GOALS = 1000
CALLED_OFF = "called off"
# Attempts to cancel the goal of a requester that has left. Each waits for its answer.
_CANCEL_ATTEMPTS = 3


class Frontend(Protocol):
    """The part that shows the station to its operator and runs its work: app, `--plain`, a verb.

    All methods but `restart` are called on its event loop.
    """

    def carry_out(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Start work that the operator requested; the app's shutdown waits for it."""

    def run_in_background(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Start work that another program requested; the shutdown does not wait for it."""

    def on_goal_answered(self, goal: QueuedGoal, outcome: Outcome) -> None:
        """Tell the operator how the robot answered a queued goal: its verb returned long before."""

    @property
    def has_person(self) -> bool:
        """True if somebody sees the requests of assistants and can answer them."""

    def close_questions(self) -> None:
        """Close the questions to the operator, because another console sent a STOP."""

    def restart(self, why: str) -> None:
        """Start the process again, or say that this is left to a person. Any thread."""


class GoalDriver:
    """The sender of goals; it gives each its answer and its outcome. Event loop only."""

    def __init__(
        self,
        robot: Robot,
        clock: Clock,
        on_changed: Callable[[], object],  # Calls `update` in its turn.
        on_ended: Callable[[asyncio.Future[Outcome] | None, Goal], None],
    ) -> None:
        self.queue = GoalQueue()
        self.frontend: Frontend | None = None  # None: no goal may be driven yet.
        self._robot, self._clock = robot, clock
        self._on_changed, self._on_ended = on_changed, on_ended
        self._snapshot = Snapshot()
        # By the goals' numbers: their answers, for verbs that wait, and their outcomes.
        self._answers: dict[int, asyncio.Future[Outcome]] = {}
        self._ends: dict[int, asyncio.Future[Outcome]] = {}
        self._called_off: set[int] = set()  # Those whose cancel was accepted, or is on its way.

    def update(self, snapshot: Snapshot, holding: Holding) -> None:
        """Report the goals that have ended, and send the one that is due, if there is one."""
        self._snapshot = snapshot
        now, stop_count = self._clock.monotonic(), self._robot.stops.total
        self._become(self.queue.seen(snapshot, now, stop_count, holding))

    def _become(self, after: GoalQueue) -> None:
        deeds, self.queue = after.todo, after._replace(todo=())
        for deed in deeds:
            self._perform(deed)

    def _perform(self, deed: Deed) -> None:
        if deed.do is QueueEffect.NOTE:
            self._robot.note("WARN", "console", deed.text)
            return
        assert deed.goal is not None
        if deed.do is QueueEffect.SEND:
            assert self.frontend is not None  # Nothing is sent without a frontend.
            self.frontend.carry_out(partial(self._send, deed.goal))
        elif deed.do is QueueEffect.CANCEL:
            assert self.frontend is not None
            self.frontend.carry_out(partial(self._cancel_for, deed.goal.requester))
        elif deed.do is QueueEffect.SETTLE:
            self._settle(deed)
        else:
            assert deed.outcome is not None
            answer = self._answers.pop(deed.goal.number, None)
            if answer is not None and not answer.done():
                answer.set_result(deed.outcome)
            elif answer is None and self.frontend is not None:
                self.frontend.on_goal_answered(deed.goal, deed.outcome)

    def _settle(self, deed: Deed) -> None:
        assert deed.goal is not None
        assert deed.outcome is not None
        end = self._ends.get(deed.goal.number)
        if deed.ended is not None:
            deed.goal.requester.goal = deed.ended
            self._on_ended(end, deed.ended)
        if end is not None and not end.done():
            end.set_result(deed.outcome)
        if deed.outcome.code is not Code.HELD:
            self._ends.pop(deed.goal.number, None)

    @property
    def busy_reason(self) -> str:
        """The reason why an assistant cannot ask for a goal now; "" if it can."""
        snapshot = self._snapshot
        if snapshot.is_stopped:
            return "the robot is stopped"
        if snapshot.running_goal is not None or self.queue.underway:
            return "another goal runs"
        if self.queue.waiting:
            return "goals wait in the queue"
        return "another goal is being sent" if self.queue.is_going else ""

    def goal_of(self, requester: Requester) -> Goal | None:
        """Return a requester's oldest goal that the robot has accepted; None if none is shown."""
        befores = [b for goal, b in self.queue.underway if goal.requester is requester]
        return ours_since(self._snapshot, befores[0]) if befores else None

    @property
    def staying(self) -> str:
        """The goals that stay in the queue when the goal that runs is cancelled, in words."""
        return ", ".join(goal.text for goal in self.queue.waiting if not goal.requester.waits)

    def drive(self, goals: Sequence[QueuedGoal]) -> asyncio.Future[Outcome]:
        """Send goals one after the other; return the answer to the first, ACCEPTED if it waits.

        For any requester but YOU, `ends` gets a future of the outcome of each goal.
        """
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[Outcome] = loop.create_future()
        requester = current_requester()
        if requester.has_left:
            answer.set_result(Outcome(Code.CANCELLED, CALLED_OFF))
            return answer
        if len(self.queue.waiting) + len(goals) > MAX_QUEUED_GOALS:
            text = f"more than {MAX_QUEUED_GOALS} goals would wait"
            answer.set_result(Outcome(Code.REFUSED, text))
            return answer
        stop_count = self._robot.stops.total_when_typed
        goals = [goal._replace(stop_count=stop_count, requester=requester) for goal in goals]
        first = self.queue.submitted + 1
        if requester is not YOU:
            ends = {first + place: loop.create_future() for place in range(len(goals))}
            self._ends |= ends
            requester.ends += ends.values()
        is_stopped = self._snapshot.is_stopped or not self._robot.stops.are_answered
        after = self.queue.submit(goals, self._snapshot, is_stopped=is_stopped)
        if after.coming is None or after.coming.goal.number != first:
            held = f", held: {after.hold_reason}" if after.hold_reason else ""
            answer.set_result(Outcome(Code.ACCEPTED, f"queued{held}"))
        else:
            self._answers[first] = answer
        self._become(after)
        self._on_changed()
        return answer

    def resume(self) -> Outcome:
        """Continue a held queue, unless a STOP came; REFUSED if it is held again at once."""
        gate = self._robot.stops.gate()
        outcome = Outcome(Code.CANCELLED, NOT_SENT) if gate.is_shut else Outcome(Code.DONE, "")
        if outcome.ok:
            self._become(self.queue.resume(gate.count_when_typed + gate.sent_elsewhere))
            self._renew_ends()
            self._on_changed()
            if self.queue.hold_reason:
                outcome = Outcome(Code.REFUSED, f"still held: {self.queue.hold_reason}")
        more = f": {outcome.text}" if outcome.text else ""
        record = AuditRecord("continue", {}, outcome.code)
        self._robot.note("YOU", "console", f"continue the queue{more}", audit_record=record)
        return outcome

    def _renew_ends(self) -> None:
        """Give the goals whose outcome was HELD a new future, also in their requesters' `ends`."""
        for goal in self.queue.waiting:
            end = self._ends.get(goal.number)
            if end is not None and end.done():
                self._ends[goal.number] = pending = end.get_loop().create_future()
                ends = goal.requester.ends
                ends[:] = [pending if other is end else other for other in ends]

    def skip(self) -> Outcome:
        """Remove the next goal of the queue, which must not be empty, with an event."""
        text = self.queue.waiting[0].text
        self._become(self.queue.skip())
        record = AuditRecord("skip", {}, Code.DONE)
        self._robot.note("YOU", "console", f"left out of the queue: {text}", audit_record=record)
        self._on_changed()
        return Outcome(Code.DONE, f"left out: {text}")

    async def cancel(self, *, another: bool = False) -> Outcome:
        """Cancel the goal of this console; one that has not left the console is never sent."""
        after = self.queue.call_off()
        if after is self.queue:
            return await self._robot.cancel(another=another)
        self._become(after)
        outcome = Outcome(Code.ACCEPTED, NEVER_LEFT)
        record = AuditRecord("cancel", {}, outcome.code)
        self._robot.note("YOU", "console", f"cancel: {outcome.text}", audit_record=record)
        return outcome

    async def call_off(self, requester: Requester) -> None:
        """Take a requester that has left out of the queue, and cancel its goal."""
        self._become(self.queue.leave(requester))
        self._on_changed()
        if self._underway_of(requester):
            await self._cancel_for(requester)

    async def _cancel_for(self, requester: Requester) -> None:
        """Cancel a requester's goal, unless this is underway: a second cancel would be rejected."""
        numbers, accepted = self._underway_of(requester), False
        if numbers and numbers <= self._called_off:
            return
        self._called_off |= numbers
        try:
            for _ in range(_CANCEL_ATTEMPTS):
                with on_behalf_of(requester):
                    outcome = await self.cancel()
                accepted = outcome.ok
                if accepted or not self._underway_of(requester):
                    return
        finally:
            if not accepted:
                self._called_off -= numbers
        text = f"the goal of {requester.source}, which has left, may still run: {outcome.text}"
        self._robot.note("ERROR", "console", text)

    def _underway_of(self, requester: Requester) -> set[int]:
        """Return the numbers of a requester's goals that the robot may carry out."""
        return {goal.number for goal, _ in self.queue.underway if goal.requester is requester}

    def take_out(self, requester: Requester) -> None:
        """Take a requester's goals out of the queue: nobody waits for them any more."""
        self._become(self.queue.take_out(requester))
        self._on_changed()

    def restore(self, goals: Sequence[QueuedGoal]) -> None:
        """Take over the goals that waited before a restart; they are held."""
        self._become(self.queue.restore(goals))

    def attach(self, frontend: Frontend) -> None:
        """Send goals by this frontend; one that the frontend before did not begin to send ends."""
        self.frontend = frontend
        self._become(self.queue.drop())

    async def _send(self, goal: QueuedGoal) -> None:
        coming = self.queue.coming
        if coming is None or coming.goal is not goal:  # A frontend before was to send it.
            return
        if coming.is_called_off:
            self._answered(Outcome(Code.CANCELLED, NEVER_LEFT))
            return
        self._become(self.queue.hand_over())
        stops = self._robot.stops
        reported = stops.sent_elsewhere
        try:
            # A report since it was typed counts like a STOP of this console.
            with (
                stops.typed_at(goal.stop_count - reported, reported),
                on_behalf_of(goal.requester),
            ):
                outcome = await self._robot.send(goal.kind, goal.values, queued=coming.waited)
        except asyncio.CancelledError:  # The screen ends. The next one learns of it as it runs.
            self._become(self.queue.lose())
            self._answers.pop(goal.number, None)
            self._ends.pop(goal.number, None)
            raise
        self._answered(outcome)

    def _answered(self, outcome: Outcome) -> None:
        self._become(self.queue.answered(outcome))
        self._on_changed()
