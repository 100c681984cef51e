"""The goals that assistants ask for: one is sent only after a person at this console agrees.

It is allowed at most once, and for exactly the values that were shown.
"""

from __future__ import annotations

from asyncio import Future
from collections.abc import Callable
from enum import Enum
from typing import TYPE_CHECKING, Any, NamedTuple

from archo_tui.base.clock import Clock
from archo_tui.base.yaml_text.dump import flow
from archo_tui.robot.clients import YOU, Requester, current_requester, on_behalf_of
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.messages.typed import check_ranges
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.stop.gate import NOT_SENT

if TYPE_CHECKING:
    from archo_tui.robot.robot import Robot
    from archo_tui.station.goal_driver import GoalDriver

MAX_WAITING = 3  # Requests that may wait for a person at a time.
LIFETIME = 60.0  # Seconds after which a request expires.
PAUSE = 10.0  # Seconds after a denial without new requests: the person sees the screen again.
READING_TIME = 1.0  # Seconds that a request must have been shown before an answer counts.
_KEPT = 100  # Requests that are kept, so that their end can be asked for.


def quoted(value: Any) -> str:
    """Return a value for the person who decides; a text is quoted where it reads like more."""
    return flow(value) if isinstance(value, str) else text_of(value)


class ApprovalStatus(Enum):
    """The state of an approval request; the value is the word for it."""

    WAITING = "waits for a person"
    ALLOWED = "allowed"
    DENIED = "denied"
    EXPIRED = "expired"
    VOID = "void"


class ApprovalRequest(NamedTuple):
    """A goal that an assistant wants."""

    number: int  # From 1, for persons and assistants.
    requester: Requester
    goal: QueuedGoal
    text: str  # The goal, as `go to shelf 12`.
    requested: float  # monotonic, s
    stop_count: int  # STOPs read by then, here and elsewhere; a further one voids it.
    status: ApprovalStatus = ApprovalStatus.WAITING
    reason: str = ""  # Why it is void or expired.
    goal_end: Future[Outcome] | None = None  # None until a person has allowed it.
    ended_goal: Goal | None = None  # None also if it was never accepted.

    def seconds_left(self, now: float) -> float:
        """Return the seconds until it expires, 0.0 at least."""
        return max(self.requested + LIFETIME - now, 0.0)

    def outdated_by(
        self, now: float, stop_count: int, busy_reason: str
    ) -> tuple[ApprovalStatus, str] | None:
        """Return why a person can no longer allow it, as status and reason; None if one can."""
        if self.stop_count != stop_count:
            return ApprovalStatus.VOID, "a STOP came"
        if self.requester.has_left:
            return ApprovalStatus.VOID, "the assistant has left"
        if busy_reason:
            return ApprovalStatus.VOID, busy_reason
        if now - self.requested >= LIFETIME:
            return ApprovalStatus.EXPIRED, f"nobody answered in {LIFETIME:g} s"
        return None


class Approvals:
    """The approval requests that wait, and the last ones that are closed. Event loop only."""

    def __init__(
        self, robot: Robot, clock: Clock, goals: GoalDriver, refresh: Callable[[], object]
    ) -> None:
        self._goals, self._robot, self._clock = goals, robot, clock
        self._refresh = refresh  # Calls `close_outdated` in its turn.
        self._all: dict[int, ApprovalRequest] = {}
        self._last_number = 0
        self._last_denial = -PAUSE  # Monotonic seconds.

    @property
    def waiting(self) -> tuple[ApprovalRequest, ...]:
        """The requests that wait for a person, the oldest first."""
        return tuple(
            request for request in self._all.values() if request.status == ApprovalStatus.WAITING
        )

    def get(self, number: int) -> ApprovalRequest | None:
        """Return the request of that number, waiting or closed; None if there is none any more."""
        return self._all.get(number)

    def _change(self, number: int, **changes: Any) -> None:
        self._all[number] = self._all[number]._replace(**changes)

    def close_outdated(self) -> None:
        """Close the requests that a person can no longer allow, with an event for each."""
        now, busy = self._clock.monotonic(), self._goals.busy_reason
        for request in self.waiting:
            outdated = request.outdated_by(now, self._robot.stops.total, busy)
            if outdated is not None:
                status, reason = outdated
                self._change(request.number, status=status, reason=reason)
                text = f"request {request.number} is {status.value}, {reason}: {request.text}"
                self._robot.note("WARN", "console", text)

    def request(self, goal: QueuedGoal, text: str) -> ApprovalRequest:
        """Ask a person to allow a goal; ValueError if nobody could allow it now."""
        requester, stops = current_requester(), self._robot.stops
        refusal = self._refusal()
        if not refusal and (requester.has_left or stops.is_void(stops.count_when_typed)):
            refusal = NOT_SENT
        if refusal or (refusal := self._too_many()):
            raise ValueError(refusal)
        self._last_number = number = self._last_number + 1
        now = self._clock.monotonic()
        request = ApprovalRequest(number, requester, goal, text, now, stops.total_when_typed)
        self._all[number] = request
        self._forget_oldest()
        values = {"request": number, "values": goal.values}
        record = AuditRecord("request", values, Code.ACCEPTED)
        asked = f"asks: {text} (request {number})"
        self._robot.note(requester.level, requester.source, asked, audit_record=record)
        self._refresh()
        return self._all[number]

    def _refusal(self) -> str:
        if self._goals.frontend is None or not self._goals.frontend.has_person:
            return "nobody can allow it: this console has no screen and no terminal"
        if self._robot.snapshot.is_stopped:
            return "the robot is stopped: a person has to release it first"
        if self._goals.busy_reason:
            return f"{self._goals.busy_reason}: wait until it has ended"
        return ""

    def _too_many(self) -> str:
        pause_left = self._last_denial + PAUSE - self._clock.monotonic()
        if pause_left > 0:
            return f"a person has just said no: wait {pause_left:.0f} s"
        is_full = len(self.waiting) >= MAX_WAITING
        return f"{MAX_WAITING} requests wait for a person already" if is_full else ""

    def _forget_oldest(self) -> None:
        waiting = {request.number for request in self.waiting}
        for number in [number for number in self._all if number not in waiting]:
            if len(self._all) > _KEPT:
                del self._all[number]

    def withdraw(self, requester: Requester) -> str:
        """Close the waiting requests of an assistant as VOID; return their goals in words."""
        withdrawn = [request for request in self.waiting if request.requester is requester]
        for request in withdrawn:
            reason = "the assistant has withdrawn it"
            self._change(request.number, status=ApprovalStatus.VOID, reason=reason)
        self._refresh()
        return ", ".join(request.text for request in withdrawn)

    def answer(self, number: int, *, allowed: bool) -> Outcome:
        """Carry out what a person has decided; DONE does not tell whether the robot accepts it."""
        self._refresh()
        request = self._all.get(number)
        if request is None:
            return Outcome(Code.REFUSED, f"there is no request {number}")
        if request.status != ApprovalStatus.WAITING:
            return Outcome(Code.REFUSED, f"request {number} is {request.status.value}")
        if allowed and self._robot.stops.gate().is_shut:
            return Outcome(Code.CANCELLED, NOT_SENT)
        action = request.goal.kind.action
        refusal = self._robot.snapshot.unavailable(action) or self._range_error(request.goal)
        if allowed and refusal:
            return Outcome(Code.REFUSED, refusal)
        if not allowed:
            self._last_denial = self._clock.monotonic()
        status = ApprovalStatus.ALLOWED if allowed else ApprovalStatus.DENIED
        self._change(number, status=status)
        verb = "allow" if allowed else "deny"
        record = AuditRecord(verb, {"request": number}, Code.DONE)
        text = f"{status.value} request {number} of {request.requester.source}: {request.text}"
        self._robot.note(YOU.level, YOU.source, text, audit_record=record)
        if allowed:
            # The ends of its earlier goals are in the hands of those that wait for them.
            ends = request.requester.ends = []
            with on_behalf_of(request.requester):
                answer = self._goals.drive([request.goal])
            self._change(number, goal_end=ends[0] if ends else answer)
        self._refresh()
        return Outcome(Code.DONE, text)

    def on_goal_ended(self, goal_end: Future[Outcome] | None, goal: Goal) -> None:
        """Record how a goal ended, recognized by its future; others are ignored."""
        for request in self._all.values():
            if goal_end is not None and request.goal_end is goal_end:
                self._change(request.number, ended_goal=goal)
                return

    def _range_error(self, goal: QueuedGoal) -> str:
        snapshot = self._robot.snapshot
        fields = snapshot.forms.get(goal.kind.id) or ()
        try:
            check_ranges(fields, snapshot.form(goal.kind), goal.values)
        except ValueError as error:
            return str(error)
        return ""
