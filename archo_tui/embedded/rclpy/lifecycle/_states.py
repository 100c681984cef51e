"""The state machine of a lifecycle node, as ROS 2's design has it: states and transitions."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from lifecycle_msgs.msg import State, Transition


class TransitionCallbackReturn(Enum):
    """The outcome of a transition's callback, which decides the next state."""

    SUCCESS = Transition.TRANSITION_CALLBACK_SUCCESS
    FAILURE = Transition.TRANSITION_CALLBACK_FAILURE
    ERROR = Transition.TRANSITION_CALLBACK_ERROR


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
    number: name.rpartition("STATE_")[2].lower()
    for name, number in vars(State).items()
    if name.startswith(("PRIMARY_STATE_", "TRANSITION_STATE_"))
}
_UNCONFIGURED, _INACTIVE, _ACTIVE, _FINALIZED, _ERROR = 1, 2, 3, 4, 15
# Each intermediate state: how it is entered, the first number of its ends, and where these lead.
_THROUGH: tuple[tuple[int, dict[int, int], str, int, int, int, int], ...] = (
    (10, {_UNCONFIGURED: 1}, "configure", 10, _INACTIVE, _UNCONFIGURED, _ERROR),
    (11, {_INACTIVE: 2}, "cleanup", 20, _UNCONFIGURED, _INACTIVE, _ERROR),
    (13, {_INACTIVE: 3}, "activate", 30, _ACTIVE, _INACTIVE, _ERROR),
    (14, {_ACTIVE: 4}, "deactivate", 40, _INACTIVE, _ACTIVE, _ERROR),
    (12, {_UNCONFIGURED: 5, _INACTIVE: 6, _ACTIVE: 7}, "shutdown", 50, _FINALIZED, _FINALIZED,
     _ERROR),
    (_ERROR, {}, "", 60, _UNCONFIGURED, _FINALIZED, _FINALIZED),
)  # fmt: skip
CALLBACKS = {state: f"on_{label or 'error'}" for state, _, label, *_ in _THROUGH}
STEPS = [
    step
    for state, begins, label, ends, *goals in _THROUGH
    for step in (
        *(Step(number, label, start, state) for start, number in begins.items()),
        *(
            Step(ends + place, f"transition_{outcome.name.lower()}", state, goal)
            for place, (outcome, goal) in enumerate(
                zip(TransitionCallbackReturn, goals, strict=True)
            )
        ),
    )
]
