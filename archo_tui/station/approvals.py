"""The way of a goal that an assistant asks for: a person at this console decides.

A goal is sent only after the person has allowed it, for exactly the values that were shown.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from archo_tui.clock import Clock
from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.messages.typed import check_ranges
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.requester import YOU, Requester, current_requester, on_behalf_of
from archo_tui.robot.stop.gate import NOT_SENT
from archo_tui.station.approval_requests import ApprovalRequest, ApprovalRequests, ApprovalStatus
from archo_tui.station.goal_driver import GoalDriver

if TYPE_CHECKING:
    from archo_tui.robot.robot import Robot


class Approvals:
    """The handling of approval requests: made, answered, withdrawn or outdated.

    Used on the event loop of the frontend only.
    """

    def __init__(
        self,
        requests: ApprovalRequests,
        robot: Robot,
        clock: Clock,
        goals: GoalDriver,
        refresh: Callable[[], object],
    ) -> None:
        """Create the handling of the requests in `requests`.

        Args:
            requests: Keeps the requests and their states.
            robot: The robot, through the console's node.
            clock: Decides when a request expires.
            goals: Sends the goals that a person allows.
            refresh: Brings the view up to date; calls `close_outdated` in its turn.
        """
        self._requests, self._goals = requests, goals
        self._robot, self._clock, self._refresh = robot, clock, refresh

    def close_outdated(self) -> None:
        """Close the requests that a person can no longer allow, with an event for each."""
        now = self._clock.monotonic()
        stop_count = self._robot.stops.count + self._robot.stops.sent_elsewhere
        busy_reason = self._goals.busy_reason
        for request in self._requests.close_outdated(now, stop_count, busy_reason):
            text = f"request {request.number} is {request.status.value}, {request.reason}"
            self._robot.note("WARN", "console", f"{text}: {request.text}")

    def request(self, goal: QueuedGoal, text: str) -> ApprovalRequest:
        """Ask a person at this console to allow a goal of the assistant that asks now.

        An event tells the person, and the view is refreshed. The call returns without waiting for
        the answer.

        Args:
            goal: The goal to send if the person allows it.
            text: The goal in words, as `go to shelf 12`.

        Returns:
            The request, which waits.

        Raises:
            ValueError: Nobody could answer, the robot is stopped or busy, a STOP came, the
                assistant has left, or `ApprovalRequests.add` refuses; the text says which.
        """
        if self._goals.frontend is None or not self._goals.frontend.has_person:
            raise ValueError("nobody can allow it: this console has no screen and no terminal")
        if self._robot.snapshot.is_stopped:
            raise ValueError("the robot is stopped: a person has to release it first")
        if self._goals.busy_reason:
            raise ValueError(f"{self._goals.busy_reason}: wait until it has ended")
        requester, stop_count = current_requester(), self._robot.stops.count_when_typed
        if requester.has_left or self._robot.stops.is_void(stop_count):
            raise ValueError(NOT_SENT)
        stop_count += self._robot.stops.sent_elsewhere
        request = self._requests.add(requester, goal, text, self._clock.monotonic(), stop_count)
        record = AuditRecord(
            "request", {"request": request.number, "values": goal.values}, Code.ACCEPTED
        )
        asked = f"asks: {text} (request {request.number})"
        self._robot.note(requester.level, requester.source, asked, audit_record=record)
        self._refresh()
        return request

    def withdraw(self, requester: Requester) -> str:
        """Close the requests of an assistant that wait for a person, as VOID.

        Returns:
            The goals of these requests in words; "" if there was none.
        """
        withdrawn = [
            request for request in self._requests.waiting if request.requester is requester
        ]
        for request in withdrawn:
            reason = "the assistant has withdrawn it"
            self._requests.close(request.number, ApprovalStatus.VOID, reason)
        self._refresh()
        return ", ".join(request.text for request in withdrawn)

    def answer(self, number: int, *, allowed: bool) -> Outcome:
        """Carry out what a person has decided: an allowed goal is sent at once, and only once.

        The decision becomes an event. The call does not wait until the goal is sent. A request
        that cannot be allowed now waits on, or is closed if it is outdated. Allowing empties the
        requester's `ends` first; after a denial no request can be made for PAUSE seconds.

        Args:
            number: The number of the request.
            allowed: False if the person denied it.

        Returns:
            DONE with the decision in words, which does not tell whether the robot accepts the goal;
            REFUSED if there is no such request, it is closed, as by a STOP since it was made, or
            its goal cannot be sent now; CANCELLED if a STOP was read after the decision.
        """
        self._refresh()
        request = self._requests.get(number)
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
        if allowed:
            self._requests.close(number, ApprovalStatus.ALLOWED)
        else:
            self._requests.deny(number, self._clock.monotonic())
        verb, word = ("allow", "allowed") if allowed else ("deny", "denied")
        record = AuditRecord(verb, {"request": number}, Code.DONE)
        text = f"{word} request {number} of {request.requester.source}: {request.text}"
        self._robot.note(YOU.level, YOU.source, text, audit_record=record)
        if allowed:
            # The ends of its earlier goals are in the hands of those that wait for them.
            ends = request.requester.ends = []
            with on_behalf_of(request.requester):
                answer = self._goals.drive([request.goal])
            self._requests.on_sent(number, ends[0] if ends else answer)
        self._refresh()
        return Outcome(Code.DONE, text)

    def _range_error(self, goal: QueuedGoal) -> str:
        """Return a text on a value of a goal that is beyond a robot's limit; "" if none is."""
        fields = self._robot.snapshot.forms.get(goal.kind.id) or ()
        try:
            check_ranges(fields, self._robot.snapshot.form(goal.kind), goal.values)
        except ValueError as error:
            return str(error)
        return ""
