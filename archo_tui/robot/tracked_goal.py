"""A goal that is tracked from its beginning to its end, whoever sent it. ROS thread only.

The rules for its phase:

- The end of a wait does not end a goal. Without an answer to the request it is UNKNOWN, without
  news while it runs LOST, until the robot reports how it ended or that it does not know it.
- Only if its node has left is it over without such a report (GONE).
- A goal that sent feedback is judged by its feedback, not by topics of other nodes: its server may
  have died while the wheels still report.
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
from archo_tui.robot.stop.gate import Gate
from archo_tui.robot.values import text_of
from archo_tui.robot_file.model import MessageField
from archo_tui.safe_text import harmless

FARTHEST = 1e6  # A larger remainder is not a reading.
# All in seconds.
SILENCE = 3.0  # Without feedback, and three periods of it: a goal that sent some is lost.
NO_PERIOD = 15.0  # Without feedback, if its period is not known: the goal is lost.
ASK_AGAIN = 5.0  # Without news of the goal: its server is asked whether it knows it.
NOBODY_SERVES = 1.0  # Without a server of its action, and without news: the goal is over.
NEVER_TAKEN = 20.0  # A server that does not know a goal may still accept it so long after.

ENDS = {
    GoalStatus.STATUS_SUCCEEDED: Phase.ARRIVED,
    GoalStatus.STATUS_CANCELED: Phase.CANCELLED,
    GoalStatus.STATUS_ABORTED: Phase.ABORTED,
}
_NO_REASON = "the robot gave no reason"
_GONE = "the robot may still be moving"
_FORGOTTEN = "the robot no longer knows this goal (was it restarted?)"
_NOT_TAKEN = f"the robot does not know this goal: it did not take it in {NEVER_TAKEN:g} s"


class TrackedGoal:
    """A goal, the handle of its client, and what was received about it.

    Attributes:
        goal: The present state.
        id: The 16 bytes of its UUID.
        action: The action and its client.
        handle: The rclpy client's handle, with which the goal can be cancelled; None before the
            server accepted the goal or is assumed to have, and after the end.
        turn: The turn in which tracking began, see `Services.next_turn`: for a goal of this console
            when it was sent, also if it was lost meanwhile, for another one when it was found.
        tried_to_cancel: When the console last tried to cancel the goal without being asked, in
            monotonic seconds; 0 if never.
        gate: The last check that the goal passed as it was sent from here; None if others sent it.
        is_cancelled: True if the operator cancelled it before the server accepted it.
        cancel_began: True once the console cancels it because it was accepted too late: after
            `is_cancelled`, or after a STOP that was read since it was typed.
        cancel_outcome: The outcome of that cancel; None before.
    """

    def __init__(
        self,
        goal: Goal,
        goal_id: bytes,
        action: Any,
        clock: Clock,
        on_change: Callable[[TrackedGoal, Goal], None],
    ) -> None:
        """Begin to track a goal.

        Args:
            goal: Its state.
            goal_id: The 16 bytes of its UUID.
            action: The action and its client.
            clock: The clock of all times.
            on_change: Called after each change with this object and the state before.
        """
        self.goal, self.id, self.action = goal, goal_id, action
        self._clock, self._on_change = clock, on_change
        self.handle: Any = None
        self.turn = 0
        self.tried_to_cancel = 0.0
        self.gate: Gate | None = None
        self.is_cancelled = False
        self.cancel_began = False
        self.cancel_outcome: Outcome | None = None
        self._result: Any = None  # The future of the last request for the result.
        self._asked = 0.0  # When it was sent, in monotonic seconds.
        self._feedback_period = Period()
        self._unserved: float | None = None  # Since when no server was found, in monotonic seconds.
        # The end by the action's status topic, and when it was received, in monotonic seconds.
        self._ended_as: tuple[Phase, float] | None = None

    @property
    def is_void(self) -> bool:
        """True if a STOP came after the goal was typed here, from this console or another one."""
        return self.gate is not None and self.gate.is_shut

    @property
    def is_unwanted(self) -> bool:
        """True if the goal must be cancelled as soon as its server accepts it."""
        return self.is_void or self.is_cancelled

    @property
    def is_accepted(self) -> bool:
        """True if the server is known to have accepted the goal, if only by its feedback."""
        return self.goal.started is not None

    def on_accepted(self, handle: Any) -> None:
        """Record that the server accepted the goal, and request the result; the phase is MOVING."""
        self.handle = handle
        now = self._clock.monotonic()
        self.update(phase=Phase.MOVING, started=now, heard=now)
        self.ask_result()

    def assume_accepted(self) -> None:
        """Set a handle as if the server had accepted the goal, so that it can be cancelled.

        For a goal whose request was not answered, or that others sent. The phase stays as it is.
        """
        accepted = self.action.type.Impl.SendGoalService.Response(accepted=True)
        goal_id = UUID(uuid=list(self.id))
        self.handle = ClientGoalHandle(self.action.client, goal_id, accepted)

    def ask_result(self) -> None:
        """Request the result, in place of an earlier request; the answer ends the goal.

        A server answers when the goal has ended, or at once if it does not know the goal: an
        accepted goal ends then, too, any other only if it was sent more than NEVER_TAKEN ago.
        """
        if self._result is not None:
            self._result.cancel()
        self._asked = self._clock.monotonic()
        self._result = self.action.ask_result(self.id)

        def on_result(future: Any) -> None:
            # A future that was done before it was cancelled still calls back. Its answer may be
            # from before the server accepted the goal, which would be called forgotten just as
            # it begins.
            is_last = future is self._result and not future.cancelled()
            if is_last and future.result() is not None and self.goal.is_running:
                self._on_result(future.result())

        self._result.add_done_callback(on_result)

    def forget_period(self, old: object, new: object) -> None:
        """Measure the period of the feedback again, since a parameter has changed.

        Until then the present period holds or, if it is about `old`, the value `new` if that is
        longer: the parameter seems to set the period.

        Args:
            old: The parameter's value before; None if the parameter is not of the goal's server.
            new: Its present value.
        """
        self._feedback_period = self._feedback_period.measured_again(old, new)

    def on_robot_message(self) -> None:
        """Change a LOST goal to UNKNOWN, since the robot sends messages again.

        The next `check` asks the server about it. A goal that has sent feedback stays LOST until it
        sends some.
        """
        if self.goal.phase == Phase.LOST and not self._sends_feedback:
            self.update(phase=Phase.UNKNOWN)
            self._asked = 0.0

    def check(self, now: float, motion: Motion, resumed: float = float("-inf")) -> None:
        """Update the phase after a silence, and ask the server about a goal without news.

        A silent goal that is MOVING or CANCELLING becomes LOST. A goal without a server and without
        news for NOBODY_SERVES ends as GONE; one that has ended by the status topic ends if its
        result does not come. Call this several times a second.

        Args:
            now: Monotonic time in seconds.
            motion: The last message about the robot's motion.
            resumed: When this process last went on after it was suspended, in monotonic seconds.
                Silence counts from then: messages that came meanwhile may still be unread.
        """
        goal = self.goal
        if self._ended_as is not None and now - self._ended_as[1] > services.DEADLINE:
            self.end(self._ended_as[0], _NO_REASON)  # The result was not received in time.
            return
        if self.action.is_served:
            self._unserved = None
        elif self._unserved is None:
            self._unserved = now
        elif now - max(self._unserved, goal.heard or 0.0, resumed) >= NOBODY_SERVES:
            self.end_as_gone()
            return
        if goal.phase in (Phase.MOVING, Phase.CANCELLING) and self._is_silent(now, motion, resumed):
            self.update(phase=Phase.LOST)
        if goal.phase == Phase.SENT:
            return
        # The server may have been restarted and forgotten the goal, while other nodes still send.
        asked, longest = max(self._asked, goal.heard or 0.0), ASK_AGAIN
        if goal.phase in (Phase.UNKNOWN, Phase.LOST):
            asked, longest = self._asked, services.DEADLINE
        if now - asked > longest and self.action.is_served:
            self.ask_result()

    @property
    def _sends_feedback(self) -> bool:
        return self._feedback_period.last is not None or self._feedback_period.known is not None

    def _is_silent(self, now: float, motion: Motion, resumed: float) -> bool:
        """Return True if a running goal, whose action has a server, has been silent for too long.

        Feedback decides. While its period is not known, or none is due, messages about the
        motion decide, too.
        """
        heard = max(self.goal.heard or self.goal.sent, resumed)
        period = self._feedback_period.seconds
        is_cancelling = self.goal.phase == Phase.CANCELLING
        if period is not None and not is_cancelling:
            return now - heard > max(SILENCE, 3 * period)
        # Since ROS 2 Lyrical a server sends no feedback for a goal that it is cancelling.
        last = max(heard, self.goal.cancel_asked or 0.0)
        if (self._sends_feedback or is_cancelling) and now - last > NO_PERIOD:
            return True
        longest = max(SILENCE, 3 * (motion.period or 0.0))
        return motion.received is not None and now - max(motion.received, heard) > longest

    def on_status(self, status: int) -> None:
        """Record the goal's status on the action's status topic.

        The first end is kept for 2 s, for the result to come first; only `check` then ends the
        goal. A MOVING goal whose status is CANCELING becomes CANCELLING.

        Args:
            status: A number of action_msgs/msg/GoalStatus; one that is neither an end nor CANCELING
                changes nothing.
        """
        if status in ENDS:
            self._ended_as = self._ended_as or (ENDS[status], self._clock.monotonic())
        elif status == GoalStatus.STATUS_CANCELING and self.goal.phase == Phase.MOVING:
            self.update(phase=Phase.CANCELLING, cancel_asked=self._clock.monotonic())

    def on_feedback(self, feedback: Any) -> None:
        """Record a feedback message of this goal; a goal that is UNKNOWN or LOST is MOVING again.

        The feedback also shows that the server accepted the goal: if that was not known, `started`
        becomes the time at which it was sent. Another phase stays.
        """
        goal, now = self.goal, self._clock.monotonic()
        self._feedback_period = self._feedback_period.with_message_at(now)
        doubtful = goal.phase in (Phase.UNKNOWN, Phase.LOST)
        changes = feedback_changes(goal, feedback, now)
        self.update(
            phase=Phase.MOVING if doubtful else goal.phase,
            heard=now,
            started=goal.sent if goal.started is None else goal.started,
            **changes,
        )

    def _on_result(self, answer: Any) -> None:
        """End the goal as the server's answer says; not if the server does not know it yet."""
        if answer.status == GoalStatus.STATUS_UNKNOWN:
            if self.is_accepted:
                self.end_forgotten()
            elif self._clock.monotonic() - self.goal.sent > NEVER_TAKEN:
                self.end(Phase.ABORTED, _NOT_TAKEN)
            return  # Otherwise the server has not decided yet, and is asked again.
        phase, result = ENDS.get(answer.status, Phase.ABORTED), answer.result
        self.goal = self.goal._replace(result=result)
        succeeded = getattr(result, "success", None)
        if isinstance(succeeded, bool) and succeeded != (phase == Phase.ARRIVED):
            action = "succeeded" if phase == Phase.ARRIVED else phase.value.lower()
            contradiction = "says not" if not succeeded else "says success"
            self.end(Phase.DISPUTED, f"the action says {action}, its result {contradiction}")
            return
        if phase == Phase.ARRIVED and self.goal.kind.remaining:
            self.goal = self.goal._replace(remaining=0.0, unreadable="")
        text = self._result_text(result)
        self.end(phase, text if text or phase == Phase.ARRIVED else _NO_REASON)

    def _result_text(self, result: Any) -> str:
        """Return the robot's message in a result; all fields if the robot file names no message."""
        if self.goal.kind.message:
            value = read(MessageField(self.goal.kind.message), result)
            return "" if value is None else text_of(value)
        return messages.text(result)

    def end_as_gone(self) -> None:
        """End the goal as GONE: its node has left, so nobody will report how it ended."""
        self.end(Phase.GONE, _GONE)

    def end_forgotten(self) -> None:
        """End the goal as ABORTED, since its server no longer knows it."""
        self.end(Phase.ABORTED, _FORGOTTEN)

    def end(self, phase: Phase, message: str) -> None:
        """End the goal: set its phase, message and time of the end, and drop its handle.

        Args:
            phase: The phase in which it ended.
            message: Why, as people read it; it may hold any characters.
        """
        self.handle = self._result = None
        now = self._clock.monotonic()
        self.update(phase=phase, message=harmless(message), ended=now)

    def update(self, **changes: Any) -> None:
        """Change fields of the goal's state by name, and call `on_change`.

        A new phase also sets `time`, and `lost` if the phase is LOST; another phase clears `lost`.

        Args:
            changes: The fields of `Goal` with their new values.
        """
        before = self.goal
        phase = changes.get("phase", before.phase)
        if phase != before.phase:
            changes["time"] = self._clock.now()
            changes["lost"] = self._clock.monotonic() if phase == Phase.LOST else None
        self.goal = before._replace(**changes)
        self._on_change(self, before)


def feedback_changes(goal: Goal, feedback: Any, now: float) -> dict[str, Any]:
    """Return the fields of a goal's state that a feedback message changes, with new values.

    If the robot file names the field with the remainder, only that is read: a number from 0 to
    FARTHEST becomes `remaining`, and perhaps `length`; any other value becomes `unreadable`.
    Otherwise all fields become the text `feedback`.
    """
    remaining = goal.kind.remaining
    if remaining is None:
        return {"feedback": messages.text(feedback)}
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
