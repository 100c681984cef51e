"""The state machine of a lifecycle node, as ROS 2's design has it: states and transitions."""

from __future__ import annotations

from enum import Enum
from typing import Any, NamedTuple

from lifecycle_msgs.msg import State, Transition
from rclpy._rclpy_pybind11 import RCLError


class TransitionCallbackReturn(Enum):
    """The outcome of a transition's callback, which decides the next state."""

    SUCCESS = Transition.TRANSITION_CALLBACK_SUCCESS
    FAILURE = Transition.TRANSITION_CALLBACK_FAILURE
    ERROR = Transition.TRANSITION_CALLBACK_ERROR

    def to_label(self) -> str:
        """Return the label of the transition that follows, such as `transition_success`."""
        return f"transition_{self.name.lower()}"


class LifecycleState(NamedTuple):
    """A state of a lifecycle node: its label and its number in lifecycle_msgs/State."""

    label: str
    state_id: int


class Step(NamedTuple):
    """A transition: its number and label, and the numbers of the states it leads from and to."""

    number: int
    label: str
    start: int
    goal: int


LABELS = {
    State.PRIMARY_STATE_UNKNOWN: "unknown",
    State.PRIMARY_STATE_UNCONFIGURED: "unconfigured",
    State.PRIMARY_STATE_INACTIVE: "inactive",
    State.PRIMARY_STATE_ACTIVE: "active",
    State.PRIMARY_STATE_FINALIZED: "finalized",
    State.TRANSITION_STATE_CONFIGURING: "configuring",
    State.TRANSITION_STATE_CLEANINGUP: "cleaningup",
    State.TRANSITION_STATE_SHUTTINGDOWN: "shuttingdown",
    State.TRANSITION_STATE_ACTIVATING: "activating",
    State.TRANSITION_STATE_DEACTIVATING: "deactivating",
    State.TRANSITION_STATE_ERRORPROCESSING: "errorprocessing",
}


def _through(
    state: int, begins: dict[int, int], label: str, ends: int, success: int, failure: int
) -> list[Step]:
    """Return the transitions into an intermediate state, and those that follow its callback."""
    error = State.TRANSITION_STATE_ERRORPROCESSING
    if state == error:
        error = State.PRIMARY_STATE_FINALIZED
    return [
        *(Step(number, label, start, state) for start, number in begins.items()),
        Step(ends, "transition_success", state, success),
        Step(ends + 1, "transition_failure", state, failure),
        Step(ends + 2, "transition_error", state, error),
    ]


_UNCONFIGURED, _INACTIVE = State.PRIMARY_STATE_UNCONFIGURED, State.PRIMARY_STATE_INACTIVE
_ACTIVE, _FINALIZED = State.PRIMARY_STATE_ACTIVE, State.PRIMARY_STATE_FINALIZED
_SHUTDOWNS = {_UNCONFIGURED: 5, _INACTIVE: 6, _ACTIVE: 7}
STEPS = [
    *_through(
        State.TRANSITION_STATE_CONFIGURING,
        {_UNCONFIGURED: 1}, "configure", 10, _INACTIVE, _UNCONFIGURED,
    ),
    *_through(
        State.TRANSITION_STATE_CLEANINGUP,
        {_INACTIVE: 2}, "cleanup", 20, _UNCONFIGURED, _INACTIVE,
    ),
    *_through(
        State.TRANSITION_STATE_ACTIVATING,
        {_INACTIVE: 3}, "activate", 30, _ACTIVE, _INACTIVE,
    ),
    *_through(
        State.TRANSITION_STATE_DEACTIVATING,
        {_ACTIVE: 4}, "deactivate", 40, _INACTIVE, _ACTIVE,
    ),
    *_through(
        State.TRANSITION_STATE_SHUTTINGDOWN,
        _SHUTDOWNS, "shutdown", 50, _FINALIZED, _FINALIZED,
    ),
    *_through(
        State.TRANSITION_STATE_ERRORPROCESSING, {}, "", 60, _UNCONFIGURED, _FINALIZED,
    ),
]  # fmt: skip


class StateMachine:
    """The current state of a lifecycle node, at first `unconfigured`, and its transitions.

    It calls no callbacks.
    """

    # The node's services, if it has a communication interface.
    service_change_state: Any = None
    service_get_state: Any = None
    service_get_available_states: Any = None
    service_get_available_transitions: Any = None
    service_get_transition_graph: Any = None

    def __init__(self) -> None:
        self._state: int = State.PRIMARY_STATE_UNCONFIGURED

    @property
    def current_state(self) -> tuple[int, str]:
        """Return number and label of the state."""
        return self._state, LABELS[self._state]

    @property
    def steps(self) -> list[Step]:
        """Return the transitions that start from the current state."""
        return [step for step in STEPS if step.start == self._state]

    def trigger_transition(self, transition: int | str) -> Step:
        """Change to the state to which a transition leads, and return the transition."""
        for step in self.steps:
            if transition in (step.number, step.label):
                self._state = step.goal
                return step
        raise RCLError(
            f"Unable to start transition {transition} from current state {self.current_state}"
        )
