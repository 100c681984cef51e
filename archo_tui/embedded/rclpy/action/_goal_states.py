"""The states of a goal and the transitions between them, as ROS 2's action design has them."""

from __future__ import annotations

from action_msgs.msg import GoalStatus
from rclpy._rclpy_pybind11 import RCLError

EXECUTE, CANCEL_GOAL, SUCCEED, ABORT, CANCELED = (
    "EXECUTE",
    "CANCEL_GOAL",
    "SUCCEED",
    "ABORT",
    "CANCELED",
)

_NEXT = {
    (GoalStatus.STATUS_ACCEPTED, EXECUTE): GoalStatus.STATUS_EXECUTING,
    (GoalStatus.STATUS_ACCEPTED, CANCEL_GOAL): GoalStatus.STATUS_CANCELING,
    (GoalStatus.STATUS_EXECUTING, CANCEL_GOAL): GoalStatus.STATUS_CANCELING,
    (GoalStatus.STATUS_EXECUTING, SUCCEED): GoalStatus.STATUS_SUCCEEDED,
    (GoalStatus.STATUS_EXECUTING, ABORT): GoalStatus.STATUS_ABORTED,
    (GoalStatus.STATUS_CANCELING, SUCCEED): GoalStatus.STATUS_SUCCEEDED,
    (GoalStatus.STATUS_CANCELING, ABORT): GoalStatus.STATUS_ABORTED,
    (GoalStatus.STATUS_CANCELING, CANCELED): GoalStatus.STATUS_CANCELED,
}

ACTIVE = (
    GoalStatus.STATUS_ACCEPTED,
    GoalStatus.STATUS_EXECUTING,
    GoalStatus.STATUS_CANCELING,
)


def next_state(state: int, event: str) -> int:
    """Return the state of a goal after an event; raise RCLError if the state does not allow it."""
    try:
        return _NEXT[state, event]
    except KeyError:
        raise RCLError(
            f"Failed to update goal state: goal_handle attempted invalid transition from state "
            f"{state}: {event}"
        ) from None


def is_cancelable(state: int) -> bool:
    """Return True for an accepted or executing goal, which a cancel request may still reach."""
    return (state, CANCEL_GOAL) in _NEXT
