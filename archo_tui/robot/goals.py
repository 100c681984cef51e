"""Follows the goals that this console sends. ROS thread only.

A goal is never declared ended because the console stopped waiting: without an answer it is UNKNOWN,
without news while it moves LOST, until the robot says how it ended, or that it does not know it.
"""

from __future__ import annotations

import uuid
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.node import Node
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from archo_tui.clock import Clock
from archo_tui.robot import interfaces, messages, services
from archo_tui.robot.period import Period
from archo_tui.robot.readings import as_received, number, read
from archo_tui.robot.services import Services
from archo_tui.robot.state import Goal, Motion, Outcome, Phase
from archo_tui.robot.text import harmless
from archo_tui.robot.values import text_of
from archo_tui.robots import check
from archo_tui.robots.model import Field, GoalKind

FARTHEST = 1e6  # a remainder beyond that is no reading
SILENCE = 3.0  # s, and three periods, without a word until a goal that runs counts as lost
HISTORY = 20  # ended goals that are kept
_FIND_PERIOD = 0.05  # s between two looks for the server of an action
_REASON_WAIT = 0.3  # s that the log line with a refusal's reason may come after the refusal

_ENDS = {
    GoalStatus.STATUS_SUCCEEDED: Phase.ARRIVED,
    GoalStatus.STATUS_CANCELED: Phase.CANCELLED,
    GoalStatus.STATUS_ABORTED: Phase.ABORTED,
}
_NO_REASON = "the robot gave no reason"
_FORGOTTEN = "the robot no longer knows this goal (was it restarted?)"


class _Action:
    """The client of one action, and what its goals report."""

    def __init__(self, node: Node, kind: GoalKind, on_feedback: Callable[[Any], None]) -> None:
        self.type = interfaces.load(kind.type)  # None: not installed here, all else works
        if self.type is None:
            return
        self.client: Any = ActionClient(node, self.type, kind.action)
        # not by the client: it forgets a goal's feedback when the result is asked for anew
        feedback = self.type.Impl.FeedbackMessage
        node.create_subscription(feedback, f"{kind.action}/_action/feedback", on_feedback, 10)

    @property
    def is_served(self) -> bool:
        """True when a server can be reached."""
        return self.type is not None and bool(self.client.server_is_ready())


class Goals:
    """The goal that runs, and those that ended."""

    def __init__(
        self,
        node: Node,
        clock: Clock,
        pending: Services,
        changed: Callable[[], None],
        say: Callable[[str, str], None],
    ) -> None:
        """`say(level, text)` is called with what happens after the verb it belongs to has ended."""
        self._node, self._clock = node, clock
        self._services = pending
        self._changed = changed
        self._say = say
        self._actions: dict[tuple[str, str], _Action] = {}  # by name and type
        self._action: Any = None  # that of the last goal
        self._pace = Period()  # of its feedback
        self._goal_id = b""
        self._handle: Any = None
        self._result: Any = None  # the future of the last question for the result
        self._asked = 0.0  # when that question was put
        self._refusals: deque[str] = deque(maxlen=5)
        self.goal: Goal | None = None
        self.history: deque[Goal] = deque(maxlen=HISTORY)

    def open(self, kind: GoalKind) -> _Action:
        """The client of an action, from now on."""
        key = (kind.action, kind.type)
        if key not in self._actions:
            self._actions[key] = _Action(self._node, kind, self._on_feedback)
        return self._actions[key]

    async def send(
        self, kind: GoalKind, values: Mapping[str, Any], length: float | None
    ) -> Outcome:
        """Send a goal; ends when it was accepted, refused, or nobody answered in time."""
        known = (kind.action, kind.type) in self._actions
        action = self.open(kind)
        if action.type is None:
            return Outcome(False, check.missing(kind.action, kind.type))
        if not known:
            await self._found(action)
        if self.goal is not None and self.goal.phase in (Phase.UNKNOWN, Phase.LOST):
            doubt = f"nothing is heard of the goal to {self.goal.name}"
            return Outcome(False, f"{doubt}: cancel it, or wait until the robot is heard")
        if self.goal is not None and self.goal.is_running:
            return Outcome(False, "a goal is already running: cancel it first")
        if not action.is_served:
            return Outcome(False, f"{kind.action} is not offered by any node")
        try:
            request = messages.goal(action.type, kind, values)
        except ValueError as error:
            return Outcome(False, str(error))
        now, time = self._clock.monotonic(), self._clock.now()
        goal = Goal(kind, values, Phase.SENT, now, time, length=length)
        self._action, self._pace = action, Period()
        self._set(goal)
        self._refusals.clear()
        self._handle = self._result = None
        self._goal_id = uuid.uuid4().bytes
        goal_id = UUID(uuid=list(self._goal_id))
        answered = self._future()

        def on_answer(done: Any) -> None:
            if self._is_current(goal) and done.result() is not None:
                self._answered(done.result())
            answered.set_result(True)
            self._wake()

        future = action.client.send_goal_async(request, goal_uuid=goal_id)
        future.add_done_callback(on_answer)
        self._services.watch(answered)
        if await answered is None:
            self._unanswered(goal_id)
            return Outcome(False, f"no answer in {services.DEADLINE:g} s: the goal may be running")
        if self._handle is None:
            reason = await self._reason()
            self._end(Phase.REFUSED, reason)
            return Outcome(False, reason)
        return Outcome(True, "accepted")

    async def _found(self, action: _Action) -> None:
        """Wait for the server of a client that was made just now."""
        end = self._clock.monotonic() + services.DEADLINE
        while not action.is_served and self._clock.monotonic() < end:
            await self._services.pause(_FIND_PERIOD)

    async def cancel(self) -> Outcome:
        """Ask to cancel the running goal; how it ends is the robot's to say."""
        goal = self.goal
        if goal is None or not goal.is_running:
            return Outcome(False, "no goal is running")
        if self._handle is None:
            return Outcome(False, "the goal has not been accepted yet")
        before = goal.phase
        self._update(phase=Phase.CANCELLING, cancel_asked=self._clock.monotonic())
        future, in_time = self._handle.cancel_goal_async(), self._future()

        def on_answer(done: Any) -> None:
            if in_time.cancelled() and not len(done.result().goals_canceling):
                self._say("WARN", "the robot rejected the cancel (its answer came late)")
            in_time.set_result(True)
            self._wake()

        future.add_done_callback(on_answer)
        self._services.watch(in_time)
        answer = future.result() if await in_time else None
        if answer is not None and len(answer.goals_canceling):
            return Outcome(True, "cancelling")
        if self._is_current(goal) and self.goal and self.goal.phase == Phase.CANCELLING:
            self._update(phase=before, cancel_asked=None)
        if answer is None:
            return Outcome(False, f"no answer to the cancel in {services.DEADLINE:g} s")
        return Outcome(False, "the robot rejected the cancel: the goal continues or has ended")

    def way_is(self, length: float | None) -> None:
        """The length of the whole way became known, maybe only after the goal was sent."""
        if length is not None and self.goal is not None and self.goal.length is None:
            self._update(length=length)

    def refused(self, reason: str) -> None:
        """Remember a log line that says why a goal is refused."""
        self._refusals.append(reason)

    def heard(self) -> None:
        """The robot was heard again: ask whether it still knows a goal that was lost."""
        if self.goal is not None and self.goal.phase == Phase.LOST:
            self._update(phase=Phase.UNKNOWN)
            self._asked = 0.0

    def check(self, now: float, motion: Motion) -> None:
        """A goal that runs and is silent is lost; ask the robot about a doubtful one."""
        goal = self.goal
        if goal is None or not goal.is_running:
            return
        if goal.phase in (Phase.MOVING, Phase.CANCELLING) and self._is_silent(goal, now, motion):
            self._update(phase=Phase.LOST)
        doubtful = goal.phase in (Phase.UNKNOWN, Phase.LOST) and self._handle is not None
        if doubtful and now - self._asked > services.DEADLINE and self._action.is_served:
            self._ask_result()

    def _is_silent(self, goal: Goal, now: float, motion: Motion) -> bool:
        """By feedback or motion, whichever came last; without motion by the feedback's own pace."""
        heard = goal.heard or goal.sent
        if motion.received is not None:
            longest = max(SILENCE, 3 * (motion.period or 0.0))
            return now - max(motion.received, heard) > longest
        promised = goal.kind.remaining is not None
        if self._action.is_served and self._pace.seconds is None and not promised:
            return False  # an action may give no feedback at all
        return now - heard > max(SILENCE, 3 * (self._pace.seconds or 0.0))

    def _answered(self, handle: Any) -> None:
        """The server accepted or refused, in time or later."""
        if handle.accepted:
            self._handle = handle
            now = self._clock.monotonic()
            self._update(phase=Phase.MOVING, started=now, heard=now)
            self._ask_result()
        elif self.goal is not None and self.goal.phase == Phase.UNKNOWN:
            self._end(Phase.REFUSED, "refused (the answer came late)")

    def _unanswered(self, goal_id: UUID) -> None:
        """Nobody accepted or refused: go on as if accepted, and ask how it ended."""
        accepted = self._action.type.Impl.SendGoalService.Response(accepted=True)
        self._handle = ClientGoalHandle(self._action.client, goal_id, accepted)
        self._update(phase=Phase.UNKNOWN)

    def _ask_result(self) -> None:
        if self._result is not None:
            self._result.cancel()
        goal = self.goal
        self._asked = self._clock.monotonic()
        self._result = self._handle.get_result_async()

        def on_result(future: Any) -> None:
            if not future.cancelled() and future.result() is not None and self._is_current(goal):
                self._ended(future.result())

        self._result.add_done_callback(on_result)

    def _ended(self, answer: Any) -> None:
        if answer.status == GoalStatus.STATUS_UNKNOWN:
            self._end(Phase.ABORTED, _FORGOTTEN)
            return
        phase, result = _ENDS.get(answer.status, Phase.ABORTED), answer.result
        succeeded = getattr(result, "success", None)
        if isinstance(succeeded, bool) and succeeded != (phase == Phase.ARRIVED):
            said = "succeeded" if phase == Phase.ARRIVED else phase.value.lower()
            but = "says not" if not succeeded else "says success"
            disagreement = f"the action says {said}, its result {but}"
            self._end(Phase.DISPUTED, disagreement)
            return
        if phase == Phase.ARRIVED and self.goal is not None and self.goal.kind.remaining:
            self.goal = replace(self.goal, remaining=0.0, unreadable="")
        said = self._said(result)
        self._end(phase, said if said or phase == Phase.ARRIVED else _NO_REASON)

    def _said(self, result: Any) -> str:
        """The robot's own words in a result; without a field for them, all its fields."""
        assert self.goal is not None
        kind = self.goal.kind
        if kind.message:
            return text_of(getattr(result, kind.message, "")) or _NO_REASON
        return messages.text(result)

    def _on_feedback(self, message: Any) -> None:
        goal = self.goal
        if goal is None or not goal.is_running or bytes(message.goal_id.uuid) != self._goal_id:
            return  # another client's
        now = self._clock.monotonic()
        self._pace = self._pace.heard(now)
        changes = self._remainder(goal, message.feedback)
        doubtful = goal.phase in (Phase.UNKNOWN, Phase.LOST)
        self._update(
            phase=Phase.MOVING if doubtful else goal.phase,
            heard=now,
            started=goal.sent if goal.started is None else goal.started,
            **changes,
        )

    def _remainder(self, goal: Goal, feedback: Any) -> dict[str, Any]:
        """What a feedback says: how much is left where the robot file knows, else every field."""
        remaining = goal.kind.remaining
        if remaining is None:
            return {"feedback": messages.text(feedback)}
        said = read(Field(remaining.field), feedback)
        left = number(said, 0.0, FARTHEST)
        if left is None:
            return {"unreadable": as_received(said)}
        changes = {"remaining": left, "unreadable": ""}
        if remaining.length is None:  # the longest that was left is the way
            changes["length"] = max(left, goal.length or 0.0)
        return changes

    async def _reason(self) -> str:
        """Why the goal was refused: an action has no field for the reason, the log has it."""
        end = self._clock.monotonic() + _REASON_WAIT
        while not self._refusals and self._clock.monotonic() < end:
            await self._services.pause(0.02)
        return self._refusals[-1] if self._refusals else "refused, no reason given"

    def _is_current(self, goal: Goal | None) -> bool:
        """True while `goal` (or a later state of it) is the one that runs."""
        now = self.goal
        return now is not None and goal is not None and now.sent == goal.sent and now.is_running

    def _end(self, phase: Phase, message: str) -> None:
        self._handle = self._result = None
        if self.goal is not None:
            now = self._clock.monotonic()
            message = harmless(message)
            ended = replace(
                self.goal, phase=phase, message=message, ended=now, time=self._clock.now()
            )
            self.history.appendleft(ended)
            if phase != Phase.REFUSED or self.goal.phase != Phase.SENT:  # else the verb says it
                self._say("GOAL", f"{ended.name} {ended.word.lower()}: {message}".rstrip(": "))
            self._set(ended)

    def _update(self, **changes: Any) -> None:
        if self.goal is not None:
            if changes.get("phase", self.goal.phase) != self.goal.phase:
                changes["time"] = self._clock.now()
            self._set(replace(self.goal, **changes))

    def _set(self, goal: Goal) -> None:
        self.goal = goal
        self._changed()

    def _future(self) -> Future[bool]:
        return Future(executor=self._node.executor)

    def _wake(self) -> None:
        if self._node.executor is not None:
            self._node.executor.wake()
