"""Follows the goals that this console sends. ROS thread only.

A goal is never declared ended because the console stopped waiting: without an answer it is UNKNOWN,
without news while it moves LOST, until the robot says how it ended.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from action_msgs.msg import GoalStatus
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient
from rclpy.node import Node

from archo_tui.robot import calls
from archo_tui.robot.calls import Calls
from archo_tui.robot.state import MOVE, Goal, Outcome, Phase

SILENCE = 3.0  # s without feedback or motor status until a moving goal counts as lost
HISTORY = 20  # ended goals that are kept
_REASON_WAIT = 0.3  # s that the log line with a refusal's reason may come after the refusal

_ENDS = {
    GoalStatus.STATUS_SUCCEEDED: Phase.ARRIVED,
    GoalStatus.STATUS_CANCELED: Phase.CANCELLED,
    GoalStatus.STATUS_ABORTED: Phase.ABORTED,
}


class Goals:
    """The goal that runs, and those that ended."""

    def __init__(self, node: Node, calls: Calls, changed: Callable[[], None]) -> None:
        self._node = node
        self._calls = calls
        self._changed = changed
        self._client = ActionClient(node, MoveToShelf, MOVE)
        self._handle: Any = None
        self._refusals: deque[str] = deque(maxlen=5)
        self.goal: Goal | None = None
        self.history: deque[Goal] = deque(maxlen=HISTORY)

    @property
    def is_offered(self) -> bool:
        """True when somebody serves the action."""
        return bool(self._client.server_is_ready())

    async def send(self, shelf: int, route_length: float | None) -> Outcome:
        """Send a goal; ends when it was accepted, refused, or nobody answered in DEADLINE."""
        if self.goal is not None and self.goal.is_running:
            return Outcome(False, "a goal is running already: cancel it first")
        now = time.monotonic()
        goal = self._set(Goal(shelf, Phase.SENT, now, time.time(), length=route_length))
        self._refusals.clear()
        future = self._client.send_goal_async(MoveToShelf.Goal(shelf_number=shelf), self._feedback)
        answer = self._node.executor.create_future()  # type: ignore[union-attr]

        def on_answer(done: Any) -> None:
            self._answered(goal, done.result())
            if not answer.done() and not answer.cancelled():
                answer.set_result(True)

        future.add_done_callback(on_answer)
        self._calls.watch(answer)
        if await answer is None:
            self._update(phase=Phase.UNKNOWN)
            return Outcome(False, f"no answer in {calls.DEADLINE:g} s: the goal may be running")
        if not self._handle.accepted:
            reason = await self._reason()
            self._end(Phase.REFUSED, reason)
            return Outcome(False, reason)
        return Outcome(True, "accepted")

    def _answered(self, sent: Goal, handle: Any) -> None:
        """The server accepted or refused, in time or later."""
        if self.goal is None or self.goal.sent != sent.sent:
            return
        self._handle = handle
        if handle.accepted:
            now = time.monotonic()
            self._update(phase=Phase.MOVING, started=now, heard=now)
            handle.get_result_async().add_done_callback(self._result)
        elif self.goal.phase == Phase.UNKNOWN:
            self._end(Phase.REFUSED, "refused (the answer came late)")

    async def cancel(self) -> Outcome:
        """Ask to cancel the running goal; how it ends is the robot's to say."""
        if self.goal is None or not self.goal.is_running:
            return Outcome(False, "no goal is running")
        if self._handle is None or self.goal.phase == Phase.SENT:
            return Outcome(False, "the goal is not accepted yet")
        before = self.goal.phase
        self._update(phase=Phase.CANCELLING, cancel_asked=time.monotonic())
        future = self._handle.cancel_goal_async()
        self._calls.watch(future)
        answer = await future
        if answer is None:
            return Outcome(False, f"no answer in {calls.DEADLINE:g} s to the cancel")
        if len(answer.goals_canceling):
            return Outcome(True, "cancelling")
        if self.goal is not None and self.goal.phase == Phase.CANCELLING:
            self._update(phase=before, cancel_asked=None)
        return Outcome(False, "the robot rejected the cancel: the goal goes on or has ended")

    def refused(self, reason: str) -> None:
        """Take note of a log line that says why a goal is refused."""
        self._refusals.append(reason)

    def heard(self) -> None:
        """The robot was heard (motor status): a lost goal is found again."""
        if self.goal is not None and self.goal.phase in (Phase.MOVING, Phase.LOST):
            self.goal = replace(self.goal, phase=Phase.MOVING)

    def check_silence(self, now: float, last_heard: float | None) -> None:
        """Declare a moving goal lost when nothing was heard for SILENCE."""
        if self.goal is None or self.goal.phase != Phase.MOVING:
            return
        last = max(last_heard or 0.0, self.goal.heard or 0.0)
        if now - last > SILENCE:
            self._update(phase=Phase.LOST)

    def _feedback(self, message: Any) -> None:
        if self.goal is None or not self.goal.is_running:
            return
        remaining = float(message.feedback.distance_remaining)
        phase = Phase.MOVING if self.goal.phase == Phase.LOST else self.goal.phase
        length = self.goal.length
        if length is None or remaining > length:
            length = remaining
        self._update(phase=phase, remaining=remaining, length=length, heard=time.monotonic())

    def _result(self, future: Any) -> None:
        answer = future.result()
        if answer is None or self.goal is None or not self.goal.is_running:
            return
        phase = _ENDS.get(answer.status, Phase.ABORTED)
        if phase == Phase.ARRIVED:
            self.goal = replace(self.goal, remaining=0.0)
        message = answer.result.final_message
        if answer.status == GoalStatus.STATUS_UNKNOWN:
            message = "the robot does not know this goal any more"
        self._end(phase, message)

    async def _reason(self) -> str:
        """The reason of the refusal: an action has no field for it, the log has."""
        end = time.monotonic() + _REASON_WAIT
        while not self._refusals and time.monotonic() < end:
            await self._pause(0.02)
        return self._refusals[-1] if self._refusals else "refused, no reason given"

    async def _pause(self, seconds: float) -> None:
        future = self._node.executor.create_future()  # type: ignore[union-attr]
        timer = self._node.create_timer(seconds, lambda: future.set_result(True))
        await future
        self._node.destroy_timer(timer)

    def _end(self, phase: Phase, message: str) -> None:
        self._handle = None
        if self.goal is not None:
            now = time.monotonic()
            ended = replace(self.goal, phase=phase, message=message, ended=now, time=time.time())
            self.history.appendleft(ended)
            self._set(ended)

    def _update(self, **changes: Any) -> None:
        if self.goal is not None:
            if changes.get("phase", self.goal.phase) != self.goal.phase:
                changes["time"] = time.time()
            self._set(replace(self.goal, **changes))

    def _set(self, goal: Goal) -> Goal:
        self.goal = goal
        self._changed()
        return goal
