"""The approval requests of assistants: a goal is sent only after a person at this console agrees.

Pure: times come in, and nothing is sent from here.
"""

from __future__ import annotations

from asyncio import Future
from collections.abc import Iterator
from enum import Enum
from typing import Any, NamedTuple

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.requester import Requester
from archo_tui.robot.state import Goal
from archo_tui.yaml_text.dump import flow

MAX_WAITING = 3  # Requests that may wait for a person at a time.
LIFETIME = 60.0  # Seconds after which a request expires.
PAUSE = 10.0  # Seconds after a denial without new requests: the person sees the screen again.
READING_TIME = 1.0  # Seconds that a request must have been shown before an answer counts.
_KEPT = 100  # Requests that are kept, so that their end can be asked for.


def quoted(value: Any) -> str:
    """Return a value of a goal as text for the person who decides.

    A string is quoted as in YAML where necessary, so that nothing in it looks like the next value.
    """
    return flow(value) if isinstance(value, str) else text_of(value)


class ApprovalStatus(Enum):
    """The state of an approval request; the value is the word for it."""

    WAITING = "waits for a person"
    ALLOWED = "allowed"
    DENIED = "denied"
    EXPIRED = "expired"
    VOID = "void"


class ApprovalRequest(NamedTuple):
    """A goal that an assistant wants: allowed at most once, and for exactly these values.

    Attributes:
        number: The number by which persons and assistants name the request, counted from 1.
        requester: The assistant.
        goal: The goal to send if a person allows it.
        text: The goal in words, as `go to shelf 12`.
        requested: The monotonic time in seconds at which the request was made.
        stop_count: STOPs read by then, at this and other consoles; a further one voids the request.
        status: The state of the request.
        reason: The reason why the request is void or expired; "" otherwise.
        goal_end: A future of the outcome of the goal; None until a person has allowed the request.
        ended_goal: The goal as it ended; None until then, and if the robot never accepted it.
    """

    number: int
    requester: Requester
    goal: QueuedGoal
    text: str
    requested: float
    stop_count: int
    status: ApprovalStatus = ApprovalStatus.WAITING
    reason: str = ""
    goal_end: Future[Outcome] | None = None
    ended_goal: Goal | None = None

    def seconds_left(self, now: float) -> float:
        """Return the seconds until the request expires, 0.0 at least.

        Args:
            now: Monotonic time in seconds.
        """
        return max(self.requested + LIFETIME - now, 0.0)


class ApprovalRequests:
    """The requests that wait for a person, and the last ones that are closed, 100 in all."""

    def __init__(self) -> None:
        """Create the collection without requests."""
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

    def add(
        self, requester: Requester, goal: QueuedGoal, text: str, now: float, stop_count: int
    ) -> ApprovalRequest:
        """Make a request that waits for a person.

        Beyond 100 requests, the oldest closed one is forgotten.

        Args:
            requester: The assistant.
            goal: The goal to send if a person allows it.
            text: The goal in words.
            now: Monotonic time in seconds.
            stop_count: STOPs read by now, at this and other consoles.

        Raises:
            ValueError: MAX_WAITING requests wait already, or a person denied one less than PAUSE
                seconds ago; the text says which.
        """
        pause_left = self._last_denial + PAUSE - now
        if pause_left > 0:
            raise ValueError(f"a person has just said no: wait {pause_left:.0f} s")
        if len(self.waiting) >= MAX_WAITING:
            raise ValueError(f"{MAX_WAITING} requests wait for a person already")
        self._last_number += 1
        number = self._last_number
        self._all[number] = ApprovalRequest(number, requester, goal, text, now, stop_count)
        self._forget_oldest()
        return self._all[number]

    def _forget_oldest(self) -> None:
        waiting = {request.number for request in self.waiting}
        for number in [number for number in self._all if number not in waiting]:
            if len(self._all) > _KEPT:
                del self._all[number]

    def close(self, number: int, status: ApprovalStatus, reason: str = "") -> ApprovalRequest:
        """Close a request: set its status and reason.

        Args:
            number: The number of a request that is kept.
            status: Anything but WAITING.
            reason: The reason why it is void or expired.

        Returns:
            The request as it is now.
        """
        self._all[number] = closed = self._all[number]._replace(status=status, reason=reason)
        return closed

    def deny(self, number: int, now: float) -> None:
        """Close a request that a person denied; no new one can be made for PAUSE seconds.

        Args:
            number: The number of a request that is kept.
            now: Monotonic time in seconds.
        """
        self.close(number, ApprovalStatus.DENIED)
        self._last_denial = now

    def on_sent(self, number: int, goal_end: Future[Outcome]) -> None:
        """Record that the goal of an allowed request was passed on to be sent.

        Args:
            number: The number of a request that is kept.
            goal_end: Will be set to the outcome of the goal.
        """
        self._all[number] = self._all[number]._replace(goal_end=goal_end)

    def on_goal_ended(self, goal_end: Future[Outcome] | None, goal: Goal) -> None:
        """Record how a goal ended; one that no request asked for is ignored.

        Args:
            goal_end: The future by which the goal is recognized: see `ApprovalRequest.goal_end`.
            goal: The goal as it ended.
        """
        for request in self._all.values():
            if goal_end is not None and request.goal_end is goal_end:
                self._all[request.number] = request._replace(ended_goal=goal)
                return

    def close_outdated(
        self, now: float, stop_count: int, busy_reason: str
    ) -> list[ApprovalRequest]:
        """Close the requests that a person can no longer allow.

        A STOP since the request, an assistant that has left, and a `busy_reason` make a request
        VOID; LIFETIME seconds make it EXPIRED.

        Args:
            now: Monotonic time in seconds.
            stop_count: STOPs read by now, at this and other consoles.
            busy_reason: The reason why no goal can be sent, which voids all requests; "" for none.

        Returns:
            The requests that were closed.
        """
        return [*self._outdated(now, stop_count, busy_reason)]

    def _outdated(self, now: float, stop_count: int, busy_reason: str) -> Iterator[ApprovalRequest]:
        for request in self.waiting:
            if request.stop_count != stop_count:
                yield self.close(request.number, ApprovalStatus.VOID, "a STOP came")
            elif request.requester.has_left:
                yield self.close(request.number, ApprovalStatus.VOID, "the assistant has left")
            elif busy_reason:
                yield self.close(request.number, ApprovalStatus.VOID, busy_reason)
            elif now - request.requested >= LIFETIME:
                reason = f"nobody answered in {LIFETIME:g} s"
                yield self.close(request.number, ApprovalStatus.EXPIRED, reason)
