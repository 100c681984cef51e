"""One goal from its beginning to its end, whoever sent it. ROS thread only.

A goal is never declared ended because the console stopped waiting: without an answer it is UNKNOWN,
without news while it runs LOST, until the robot says how it ended, or that it does not know it.
It is over without that only when its node has gone (GONE). What another node reports of the robot
says nothing about a goal that sent feedback: its server may have died while the wheels report.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action.client import ClientGoalHandle
from unique_identifier_msgs.msg import UUID

from archo_tui.clock import Clock
from archo_tui.robot import messages, services
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.period import Period
from archo_tui.robot.readings import as_received, number, read
from archo_tui.robot.state import Goal, Motion, Phase
from archo_tui.robot.stops import Gate
from archo_tui.robot.text import harmless
from archo_tui.robot.values import text_of
from archo_tui.robot_file.model import MessageField

FARTHEST = 1e6  # a remainder beyond that is not a reading
NO_PERIOD = 15.0  # s without feedback, where its period is not known, until a goal counts as lost
ASK_AGAIN = 5.0  # s without a word of a goal itself, until its server is asked whether it knows it
NOBODY_SERVES = 1.0  # s that nobody serves its action, and it is not heard of, until it is over
NEVER_TAKEN = 20.0  # s in which a server that does not know a goal may still decide to take it
SILENCE = 3.0  # s, and three periods, without feedback until a goal that sent some counts as lost

ENDS = {
    GoalStatus.STATUS_SUCCEEDED: Phase.ARRIVED,
    GoalStatus.STATUS_CANCELED: Phase.CANCELLED,
    GoalStatus.STATUS_ABORTED: Phase.ABORTED,
}
_NO_REASON = "the robot gave no reason"
_GONE = "the robot may still be moving"
_FORGOTTEN = "the robot no longer knows this goal (was it restarted?)"
_NOT_TAKEN = f"the robot does not know this goal: it did not take it in {NEVER_TAKEN:g} s"


class Followed:
    """A goal, its client's handle, and what is heard of it."""

    def __init__(
        self,
        goal: Goal,
        goal_id: bytes,
        action: Any,
        clock: Clock,
        changed: Callable[[Followed, Goal], None],
    ) -> None:
        """`changed(self, before)` is called with each new state."""
        self.goal, self.id, self.action = goal, goal_id, action
        self._clock, self._changed = clock, changed
        self.handle: Any = None
        self.since = clock.monotonic()  # by this clock, whoever sent it
        self.tried_to_cancel = 0.0  # monotonic s, by the console itself
        self.gate: Gate | None = None  # that it passed as it was sent from here
        self.is_cancelled = False  # the operator asked for it before the server took the goal
        self.cancel_began = False  # because of that, or of a STOP, as it was accepted
        self.cancel_outcome: Outcome | None = None  # of that cancel
        self._result: Any = None  # the future of the last question for the result
        self._asked = 0.0  # when that question was put
        self._pace = Period()  # of its feedback
        self._unserved: float | None = None  # since when nobody serves its action, monotonic s
        self._ended_as: tuple[Phase, float] | None = None  # by the action's status, and since when

    @property
    def is_void(self) -> bool:
        """True when a STOP was read after it was typed."""
        return self.gate is not None and self.gate.is_shut

    @property
    def is_unwanted(self) -> bool:
        """True when it is to be cancelled as soon as its server takes it."""
        return self.is_void or self.is_cancelled

    @property
    def is_taken(self) -> bool:
        """True when its server is known to have accepted it."""
        return self.goal.started is not None

    def accepted(self, handle: Any) -> None:
        """The server took it, in time or later."""
        self.handle = handle
        now = self._clock.monotonic()
        self.update(phase=Phase.MOVING, started=now, heard=now)
        self.ask_result()

    def assume(self) -> None:
        """Go on as if the server had taken it: it was not heard that it did."""
        accepted = self.action.type.Impl.SendGoalService.Response(accepted=True)
        goal_id = UUID(uuid=list(self.id))
        self.handle = ClientGoalHandle(self.action.client, goal_id, accepted)

    def ask_result(self) -> None:
        """Ask how it ends; the answer comes when it has."""
        if self._result is not None:
            self._result.cancel()
        self._asked = self._clock.monotonic()
        self._result = self.action.ask_result(self.id)

        def on_result(future: Any) -> None:
            # one that was done before it was cancelled still calls back, and may be from before
            # the server took the goal: it would be called forgotten as it begins to drive
            is_last = future is self._result and not future.cancelled()
            if is_last and future.result() is not None and self.goal.is_running:
                self._on_result(future.result())

        self._result.add_done_callback(on_result)

    def measure_anew(self, old: object, new: object) -> None:
        """Measure the period of its feedback anew, because a parameter has changed.

        Args:
            old: What the parameter was; None: it is of another node than the goal's server.
            new: What it is.
        """
        self._pace = self._pace.anew(old, new)

    def heard(self) -> None:
        """Ask about a goal that was lost with the robot, which is heard again.

        One that sent feedback stays lost until it sends some.
        """
        if self.goal.phase == Phase.LOST and not self._sends_feedback:
            self.update(phase=Phase.UNKNOWN)
            self._asked = 0.0

    def check(self, now: float, motion: Motion, resumed: float = float("-inf")) -> None:
        """Silent it is lost; ask the robot about a doubtful one.

        Args:
            now: Monotonic time in s.
            motion: What was last heard of the robot's motion.
            resumed: When this process last went on after it stood still, monotonic s. Silence
                counts from then: what was said meanwhile may be read behind this check.
        """
        goal = self.goal
        if self._ended_as is not None and now - self._ended_as[1] > services.DEADLINE:
            self.end(self._ended_as[0], _NO_REASON)  # the result does not come
            return
        if self.action.is_served:
            self._unserved = None
        elif self._unserved is None:
            self._unserved = now
        elif now - max(self._unserved, goal.heard or 0.0, resumed) >= NOBODY_SERVES:
            self.node_gone()
            return
        if goal.phase in (Phase.MOVING, Phase.CANCELLING) and self._is_silent(now, motion, resumed):
            self.update(phase=Phase.LOST)
        if goal.phase == Phase.SENT:
            return
        # while the robot is heard, its server may have been restarted: it would say nothing more
        asked, longest = max(self._asked, goal.heard or 0.0), ASK_AGAIN
        if goal.phase in (Phase.UNKNOWN, Phase.LOST):
            asked, longest = self._asked, services.DEADLINE
        if now - asked > longest and self.action.is_served:
            self.ask_result()

    @property
    def _sends_feedback(self) -> bool:
        return self._pace.last is not None or self._pace.known is not None

    def _is_silent(self, now: float, motion: Motion, resumed: float) -> bool:
        """Return whether too little is heard of a goal that runs, and whose action is served.

        By its feedback; while its period is not known, and while none is due, by the motion, too.
        """
        heard, period = max(self.goal.heard or self.goal.sent, resumed), self._pace.seconds
        is_cancelling = self.goal.phase == Phase.CANCELLING
        if period is not None and not is_cancelling:
            return now - heard > max(SILENCE, 3 * period)
        # since Lyrical a server sends no feedback of a goal that it is cancelling
        last = max(heard, self.goal.cancel_asked or 0.0)
        if (self._sends_feedback or is_cancelling) and now - last > NO_PERIOD:
            return True
        longest = max(SILENCE, 3 * (motion.period or 0.0))
        return motion.received is not None and now - max(motion.received, heard) > longest

    def on_status(self, status: int) -> None:
        """What the action says of it."""
        if status in ENDS:
            self._ended_as = self._ended_as or (ENDS[status], self._clock.monotonic())
        elif status == GoalStatus.STATUS_CANCELING and self.goal.phase == Phase.MOVING:
            self.update(phase=Phase.CANCELLING, cancel_asked=self._clock.monotonic())

    def on_feedback(self, feedback: Any) -> None:
        """How it goes on."""
        goal, now = self.goal, self._clock.monotonic()
        self._pace = self._pace.heard(now)
        doubtful = goal.phase in (Phase.UNKNOWN, Phase.LOST)
        changes = said_by(goal, feedback)
        if goal.is_found and goal.first is None and "remaining" in changes:
            changes["first"] = now, changes["remaining"]
        self.update(
            phase=Phase.MOVING if doubtful else goal.phase,
            heard=now,
            started=goal.sent if goal.started is None else goal.started,
            **changes,
        )

    def _on_result(self, answer: Any) -> None:
        if answer.status == GoalStatus.STATUS_UNKNOWN:
            if self.is_taken:
                self.forgotten()
            elif self._clock.monotonic() - self.goal.sent > NEVER_TAKEN:
                self.end(Phase.ABORTED, _NOT_TAKEN)
            return  # else its server has not decided yet, and is asked again
        phase, result = ENDS.get(answer.status, Phase.ABORTED), answer.result
        self.goal = self.goal._replace(result=result)
        succeeded = getattr(result, "success", None)
        if isinstance(succeeded, bool) and succeeded != (phase == Phase.ARRIVED):
            said = "succeeded" if phase == Phase.ARRIVED else phase.value.lower()
            but = "says not" if not succeeded else "says success"
            self.end(Phase.DISPUTED, f"the action says {said}, its result {but}")
            return
        if phase == Phase.ARRIVED and self.goal.kind.remaining:
            self.goal = self.goal._replace(remaining=0.0, unreadable="")
        said = self._said(result)
        self.end(phase, said if said or phase == Phase.ARRIVED else _NO_REASON)

    def _said(self, result: Any) -> str:
        """The robot's own words in a result; without a field for them, all its fields."""
        if self.goal.kind.message:
            said = read(MessageField(self.goal.kind.message), result)
            return "" if said is None else text_of(said)
        return messages.text(result)

    def node_gone(self) -> None:
        """End it: its node has gone, and nobody will tell how it ended.

        This is the one rule for screen, queue, `--plain` and shells, whoever has found it out.
        """
        self.end(Phase.GONE, _GONE)

    def forgotten(self) -> None:
        """The robot does not know it."""
        self.end(Phase.ABORTED, _FORGOTTEN)

    def end(self, phase: Phase, message: str) -> None:
        """It is over."""
        self.handle = self._result = None
        now = self._clock.monotonic()
        self.update(phase=phase, message=harmless(message), ended=now)

    def update(self, **changes: Any) -> None:
        """It is so now."""
        before = self.goal
        phase = changes.get("phase", before.phase)
        if phase != before.phase:
            changes["time"] = self._clock.now()
            changes["lost"] = self._clock.monotonic() if phase == Phase.LOST else None
        self.goal = before._replace(**changes)
        self._changed(self, before)


def said_by(goal: Goal, feedback: Any) -> dict[str, Any]:
    """What a feedback changes: how much is left where the robot file knows, else every field."""
    remaining = goal.kind.remaining
    if remaining is None:
        return {"feedback": messages.text(feedback)}
    said = read(MessageField(remaining.field), feedback)
    left = number(said, 0.0, FARTHEST)
    if left is None:
        return {"unreadable": as_received(said)}
    changes: dict[str, Any] = {"remaining": left, "unreadable": ""}
    is_guess = goal.length is None or goal.length_is_guessed
    if is_guess and not goal.is_found:  # the longest that was left is the way
        changes |= {"length": max(left, goal.length or 0.0), "length_is_guessed": True}
    return changes
