"""The goals that other clients sent, found by their status and feedback. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.node import Node

from archo_tui.clock import Clock
from archo_tui.robot.goal_action import GoalAction
from archo_tui.robot.goal_canceller import GoalCanceller
from archo_tui.robot.goal_register import GoalRegister
from archo_tui.robot.services import Services
from archo_tui.robot.state import Goal, Phase
from archo_tui.robot.tracked_goal import ENDS, NOBODY_SERVES, TrackedGoal

# In seconds.
_NEW = 1.0  # A younger goal has just begun.
_LONGEST_AGE = 86_400.0  # An older goal has a stamp of another clock.

_RUNNING = {
    GoalStatus.STATUS_ACCEPTED: Phase.MOVING,
    GoalStatus.STATUS_EXECUTING: Phase.MOVING,
    GoalStatus.STATUS_CANCELING: Phase.CANCELLING,
}


def _seconds(status: Any) -> float:
    """Return when the server accepted a goal, in seconds by the robot's clock.

    Args:
        status: A message action_msgs/msg/GoalStatus.
    """
    stamp = status.goal_info.stamp
    return float(stamp.sec + stamp.nanosec / 1e9)


class GoalFinder:
    """The receiver of status and feedback messages.

    It passes them on to the goals that are tracked, and tracks those that other clients sent.
    """

    def __init__(
        self,
        node: Node,
        clock: Clock,
        pending: Services,
        register: GoalRegister,
        canceller: GoalCanceller,
        note: Callable[[str, str], None],
        watching: bool,
    ) -> None:
        """Create the finder.

        Args:
            node: The console's node.
            clock: The clock of all times.
            pending: Numbers what happens in its order.
            register: The goals that are tracked; found ones are added.
            canceller: Cancels a goal of this console whose feedback shows that it was accepted
                after a STOP or a cancel.
            note: Called with level and text of an event: a goal of another client was found.
            watching: True for a console that sends nothing.
        """
        self._node, self._clock, self._register = node, clock, register
        self._services, self._canceller = pending, canceller
        self._note, self._watching = note, watching

    def on_status(self, action: GoalAction, message: Any) -> None:
        """Update the goals of an action by a status message, and track those that others sent.

        A goal that is new to the console and runs is reported as an event, and its result is
        requested. With a single server, so is one that began and ended since the last message, and
        a goal of another client that is no longer in the message ends.

        Args:
            action: The action.
            message: The status of all goals that its server knows.
        """
        reported = {bytes(s.goal_info.goal_id.uuid): s for s in message.status_list}
        # Each of several servers reports only its own goals.
        alone = self._node.count_publishers(action.status_topic) == 1
        for goal_id, status in reported.items():
            tracked = self._register.running.get(goal_id)
            if tracked is not None:
                tracked.on_status(status.status)
            elif status.status in _RUNNING or (alone and self._is_missed(action, goal_id, status)):
                self._track_reported(action, goal_id, status)
        if not alone:
            return
        action.reported = set(reported)
        for tracked in list(self._register.running.values()):
            if tracked.action is action and not tracked.goal.mine and tracked.id not in reported:
                tracked.end_forgotten()

    def _is_missed(self, action: GoalAction, goal_id: bytes, status: Any) -> bool:
        """Return True for an ended goal that began and ended between two status messages.

        False for goals that ended before the console began.
        """
        if status.status not in ENDS or goal_id in self._register.ended_ids:
            return False
        if action.reported is not None:
            return goal_id not in action.reported
        return _seconds(status) >= action.since  # Otherwise it ended before the console began.

    def _track_reported(self, action: GoalAction, goal_id: bytes, status: Any) -> None:
        """Track a goal that appears in a status message, and request its result."""
        now = self._clock.monotonic()
        age = self._clock.now() - _seconds(status)
        begun = now - age if 0 <= age <= _LONGEST_AGE else now
        phase = _RUNNING.get(status.status, Phase.MOVING)
        is_new = 0 <= age < _NEW or action.reported is not None
        tracked = self._track_found(action, goal_id, phase, begun, is_new=is_new)
        tracked.on_status(status.status)
        tracked.ask_result()

    def _track_found(
        self, action: GoalAction, goal_id: bytes, phase: Phase, begun: float, *, is_new: bool
    ) -> TrackedGoal:
        """Track a goal that another client sent, or that was lost, and report it as an event.

        Args:
            action: The action.
            goal_id: The 16 bytes of the goal's UUID. A lost goal with it is taken out of `lost`,
                and keeps its values.
            phase: The phase of the goal.
            begun: When the goal began, in monotonic seconds.
            is_new: False if the goal may have been underway for some time.
        """
        now, time = self._clock.monotonic(), self._clock.now()
        asked = now if phase == Phase.CANCELLING else None
        lost = self._register.lost.pop(goal_id, None)
        fields, mine = ({}, False) if lost is None else (lost.goal.fields, lost.goal.mine)
        goal = Goal(
            *(action.kind, fields, phase, begun, time),
            heard=now,
            started=begun,
            cancel_asked=asked,
            mine=mine,
            number=self._register.next_number(),
            is_found=lost is not None or not is_new,
        )
        tracked = self._register.prepare(goal, goal_id, action)
        tracked.turn = self._services.next_turn()
        if lost is not None:  # A STOP since then is meant for it, too.
            tracked.turn, tracked.gate = lost.turn, lost.gate
        self._register.add(tracked)
        if not self._watching:
            tracked.assume_accepted()
            self._canceller.cancel_if_unwanted(tracked)
        sent = f"another client sent a goal to {action.kind.action}"
        again = f"{goal.name} was not lost: its node is heard again"
        self._note("GOAL", sent if lost is None else again)
        return tracked

    def on_feedback(self, action: GoalAction, message: Any) -> None:
        """Pass a feedback message on to its goal, and track a goal again that was lost.

        Feedback of a goal that is neither tracked nor lost is ignored. If a STOP or a
        cancel came before the goal's acceptance was known, or while nothing was known of the goal,
        its cancel begins now.
        """
        goal_id = bytes(message.goal_id.uuid)
        tracked = self._register.running.get(goal_id) or self._track_again(action, goal_id)
        if tracked is not None:
            was_unknown = tracked.goal.phase == Phase.UNKNOWN
            tracked.on_feedback(message.feedback)
            # The answer that it was accepted may have been lost.
            if tracked.is_cancelled or was_unknown:
                self._canceller.cancel_if_unwanted(tracked)

    def _track_again(self, action: GoalAction, goal_id: bytes) -> TrackedGoal | None:
        """Track a lost goal again whose feedback comes, and return it; None for any other goal.

        None, too, while the action has no server, and in the first second after the loss. Fast DDS
        does not send the status again to a console that lost sight of the node.
        """
        lost, now = self._register.lost.get(goal_id), self._clock.monotonic()
        # Feedback from before its node left may be read a little later.
        if lost is None or not action.is_served:
            return None
        if now - (lost.goal.ended or now) < NOBODY_SERVES:
            return None
        begun = now if lost.goal.started is None else lost.goal.started
        tracked = self._track_found(action, goal_id, Phase.MOVING, begun, is_new=False)
        tracked.ask_result()
        return tracked
