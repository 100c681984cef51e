"""The module `rclpy.lifecycle.node`: nodes with states, and services that change them."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from functools import partial, partialmethod
from typing import Any, NamedTuple, TypeVar

from lifecycle_msgs.msg import State, Transition, TransitionDescription, TransitionEvent
from lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from rclpy._rclpy_pybind11 import RCLError
from rclpy.node import Node
from rclpy.publisher import Publisher

MsgT = TypeVar("MsgT")


class TransitionCallbackReturn(Enum):
    """The outcome of a transition's callback, which decides the next state."""

    SUCCESS = Transition.TRANSITION_CALLBACK_SUCCESS
    FAILURE = Transition.TRANSITION_CALLBACK_FAILURE
    ERROR = Transition.TRANSITION_CALLBACK_ERROR


class LifecycleState(NamedTuple):
    """A state of a lifecycle node: its label and its number in lifecycle_msgs/State."""

    label: str
    state_id: int


class _Step(NamedTuple):
    """A transition: its number and label, and the numbers of the states it leads from and to."""

    number: int
    label: str
    start: int
    goal: int


_LABELS = {
    number: name.rpartition("STATE_")[2].lower()
    for name, number in vars(State).items()
    if name.startswith(("PRIMARY_STATE_", "TRANSITION_STATE_"))
}
_UNCONFIGURED, _INACTIVE, _ACTIVE, _FINALIZED, _FAULTY = 1, 2, 3, 4, 15
# Each intermediate state: how it is entered, the first number of its ends, and where these lead.
_THROUGH: tuple[tuple[int, dict[int, int], str, int, int, int, int], ...] = (
    (10, {_UNCONFIGURED: 1}, "configure", 10, _INACTIVE, _UNCONFIGURED, _FAULTY),
    (11, {_INACTIVE: 2}, "cleanup", 20, _UNCONFIGURED, _INACTIVE, _FAULTY),
    (13, {_INACTIVE: 3}, "activate", 30, _ACTIVE, _INACTIVE, _FAULTY),
    (14, {_ACTIVE: 4}, "deactivate", 40, _INACTIVE, _ACTIVE, _FAULTY),
    (12, {_UNCONFIGURED: 5, _INACTIVE: 6, _ACTIVE: 7}, "shutdown", 50, _FINALIZED, _FINALIZED,
     _FAULTY),
    (_FAULTY, {}, "", 60, _UNCONFIGURED, _FINALIZED, _FINALIZED),
)  # fmt: skip
_CALLBACKS = {state: f"on_{label or 'error'}" for state, _, label, *_ in _THROUGH}
_STEPS = [
    step
    for state, begins, label, ends, *goals in _THROUGH
    for step in (
        *(_Step(number, label, start, state) for start, number in begins.items()),
        *(
            _Step(ends + place, f"transition_{outcome.name.lower()}", state, goal)
            for place, (outcome, goal) in enumerate(
                zip(TransitionCallbackReturn, goals, strict=True)
            )
        ),
    )
]
_SUCCESS, _ERROR = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.ERROR


class LifecyclePublisher(Publisher[MsgT]):
    """A publisher that is silent unless it has been activated with its node."""

    is_activated = False

    def publish(self, msg: MsgT | bytes) -> None:
        """Send a message as `Publisher.publish` does; do nothing while not `is_activated`."""
        if self.is_activated:
            super().publish(msg)


class LifecycleNodeMixin:
    """A mixin that makes a Node a lifecycle node; it is listed before Node among the bases.

    A node overrides the callbacks, each of which gets the state before the transition. Its
    `on_activate` and `on_deactivate` call those of this class as well, for the publishers. An
    exception of a callback is logged and counts as ERROR, after which `on_error` is called.
    """

    def __init__(self, *, enable_communication_interface: bool = True) -> None:
        self._state: int = State.PRIMARY_STATE_UNCONFIGURED
        self._transition_events: Publisher[TransitionEvent] | None = None
        if not enable_communication_interface:
            return
        node: Any = self
        self._transition_events = node.create_publisher(
            TransitionEvent, f"{node.get_name()}/transition_event", 10
        )
        node.create_service(ChangeState, f"{node.get_name()}/change_state", self._change)
        every: Any = GetAvailableTransitions
        for srv_type, name, field, ask in (
            (GetState, "get_state", "current_state", lambda: _state(self._state)),
            (GetAvailableStates, "get_available_states", "available_states", lambda: _STATES),
            (every, "get_available_transitions", "available_transitions", self._descriptions),
            (every, "get_transition_graph", "available_transitions", lambda: _GRAPH),
        ):
            node.create_service(srv_type, f"{node.get_name()}/{name}", partial(_tell, field, ask))

    def create_lifecycle_publisher(self, *args: Any, **kwargs: Any) -> LifecyclePublisher[Any]:
        """Create a publisher that is silent until the node is activated, and once deactivated."""
        node: Any = self
        made = node.create_publisher(*args, publisher_class=LifecyclePublisher, **kwargs)
        publisher: LifecyclePublisher[Any] = made
        return publisher

    def destroy_lifecycle_publisher(self, publisher: LifecyclePublisher[Any]) -> bool:
        """Destroy a publisher of this node; return False for any other."""
        node: Any = self
        return bool(node.destroy_publisher(publisher))

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Configure the node, which was `unconfigured`."""
        return _SUCCESS

    on_cleanup = on_shutdown = on_error = on_configure

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Activate the publishers; the node was `inactive`."""
        return self._activate(True)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Deactivate the publishers; the node was `active`."""
        return self._activate(False)

    def _activate(self, activated: bool) -> TransitionCallbackReturn:
        node: Any = self
        for publisher in node._all(LifecyclePublisher):
            publisher.is_activated = activated
        return _SUCCESS

    def _run_transition(self, transition: int | str) -> TransitionCallbackReturn:
        """Go through a transition with its callback, and return the callback's outcome.

        If the transition does not start from the current state, an error is logged and ERROR
        returned.
        """
        node: Any = self
        before = LifecycleState(_LABELS[self._state], self._state)
        try:
            self._take(transition)
        except RCLError as error:
            node.get_logger().error(str(error))
            return _ERROR
        outcome = self._call(before)
        self._take(f"transition_{outcome.name.lower()}")
        if self._state == State.TRANSITION_STATE_ERRORPROCESSING:
            self._take(f"transition_{self._call(before).name.lower()}")
        return outcome

    # Each runs its callback, changes the state by the outcome, and returns the outcome.
    trigger_configure = partialmethod(_run_transition, "configure")
    trigger_cleanup = partialmethod(_run_transition, "cleanup")
    trigger_activate = partialmethod(_run_transition, "activate")
    trigger_deactivate = partialmethod(_run_transition, "deactivate")
    trigger_shutdown = partialmethod(_run_transition, "shutdown")

    def _steps(self) -> list[_Step]:
        return [step for step in _STEPS if step.start == self._state]

    def _call(self, before: LifecycleState) -> TransitionCallbackReturn:
        node: Any = self
        callback = _CALLBACKS[self._state]
        try:
            said: TransitionCallbackReturn = getattr(self, callback)(before)
        except Exception as error:
            node.get_logger().error(f"{callback}: {type(error).__name__}: {error}")
            return _ERROR
        return said

    def _take(self, transition: int | str) -> None:
        for step in self._steps():
            if transition in (step.number, step.label):
                self._state = step.goal
                if self._transition_events is not None:
                    start, goal = _state(step.start), _state(step.goal)
                    event = TransitionEvent(start_state=start, goal_state=goal)
                    self._transition_events.publish(event)
                return
        current = _LABELS[self._state]
        raise RCLError(f"Unable to start transition {transition} from current state {current}")

    def _change(self, request: Any, response: Any) -> Any:
        wanted = request.transition.label or request.transition.id
        response.success = self._run_transition(wanted) == _SUCCESS
        return response

    def _descriptions(self) -> list[TransitionDescription]:
        return [_description(step) for step in self._steps()]


class LifecycleNode(LifecycleNodeMixin, Node):
    """A Node with states; the other arguments are those of Node."""

    def __init__(
        self, node_name: str, *, enable_communication_interface: bool = True, **kwargs: Any
    ) -> None:
        Node.__init__(self, node_name, **kwargs)
        LifecycleNodeMixin.__init__(
            self, enable_communication_interface=enable_communication_interface
        )


def _state(number: int) -> State:
    return State(id=number, label=_LABELS[number])


def _description(step: _Step) -> TransitionDescription:
    return TransitionDescription(
        transition=Transition(id=step.number, label=step.label),
        start_state=_state(step.start),
        goal_state=_state(step.goal),
    )


def _tell(field: str, ask: Callable[[], Any], request: Any, response: Any) -> Any:
    setattr(response, field, ask())
    return response


_STATES = [_state(number) for number in _LABELS]
_GRAPH = [_description(step) for step in _STEPS]
