"""The states of a goal and the transitions between them, as ROS 2's action design has them."""

from __future__ import annotations

from enum import Enum

from action_msgs.msg import GoalStatus
from rclpy._rclpy_pybind11 import RCLError


class GoalEvent(Enum):
    """The events that move a goal from one state to another, as rclpy names them."""

    EXECUTE = 0
    CANCEL_GOAL = 1
    SUCCEED = 2
    ABORT = 3
    CANCELED = 4


_NEXT = {
    (GoalStatus.STATUS_ACCEPTED, GoalEvent.EXECUTE): GoalStatus.STATUS_EXECUTING,
    (GoalStatus.STATUS_ACCEPTED, GoalEvent.CANCEL_GOAL): GoalStatus.STATUS_CANCELING,
    (GoalStatus.STATUS_EXECUTING, GoalEvent.CANCEL_GOAL): GoalStatus.STATUS_CANCELING,
    (GoalStatus.STATUS_EXECUTING, GoalEvent.SUCCEED): GoalStatus.STATUS_SUCCEEDED,
    (GoalStatus.STATUS_EXECUTING, GoalEvent.ABORT): GoalStatus.STATUS_ABORTED,
    (GoalStatus.STATUS_CANCELING, GoalEvent.SUCCEED): GoalStatus.STATUS_SUCCEEDED,
    (GoalStatus.STATUS_CANCELING, GoalEvent.ABORT): GoalStatus.STATUS_ABORTED,
    (GoalStatus.STATUS_CANCELING, GoalEvent.CANCELED): GoalStatus.STATUS_CANCELED,
}

ACTIVE = (
    GoalStatus.STATUS_ACCEPTED,
    GoalStatus.STATUS_EXECUTING,
    GoalStatus.STATUS_CANCELING,
)


def next_state(state: int, event: GoalEvent) -> int:
    """Return the state of a goal after an event; raise RCLError if the state does not allow it."""
    try:
        return _NEXT[state, event]
    except KeyError:
        raise RCLError(
            f"Failed to update goal state: goal_handle attempted invalid transition from state "
            f"{state}: {event.name}"
        ) from None


def is_cancelable(state: int) -> bool:
    """Return True for an accepted or executing goal, which a cancel request may still reach."""
    return (state, GoalEvent.CANCEL_GOAL) in _NEXT
