"""The module `rclpy.lifecycle.node`: nodes with states, and services that change them."""

from __future__ import annotations

from functools import partialmethod
from typing import Any, TypeVar

from lifecycle_msgs.msg import State, Transition, TransitionDescription, TransitionEvent
from lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from rclpy._rclpy_pybind11 import RCLError
from rclpy.lifecycle._states import (
    CALLBACKS,
    LABELS,
    STEPS,
    LifecycleState,
    Step,
    TransitionCallbackReturn,
)
from rclpy.node import Node
from rclpy.publisher import Publisher

MsgT = TypeVar("MsgT")
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
        for srv_type, name, callback in (
            (ChangeState, "change_state", self._change),
            (GetState, "get_state", self._tell_state),
            (GetAvailableStates, "get_available_states", self._tell_states),
            (GetAvailableTransitions, "get_available_transitions", self._tell_transitions),
            (GetAvailableTransitions, "get_transition_graph", self._tell_graph),
        ):
            node.create_service(srv_type, f"{node.get_name()}/{name}", callback)

    def create_lifecycle_publisher(self, *args: Any, **kwargs: Any) -> LifecyclePublisher[Any]:
        """Create a publisher that is silent until the node is activated, and once deactivated."""
        node: Any = self
        made = node.create_publisher(*args, publisher_class=LifecyclePublisher, **kwargs)
        publisher: LifecyclePublisher[Any] = made
        return publisher

    def destroy_lifecycle_publisher(self, publisher: LifecyclePublisher[Any]) -> bool:
        """Destroy a publisher of this node; return False for any other."""
        node: Any = self
        destroyed: bool = node.destroy_publisher(publisher)
        return destroyed

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
        for publisher in node._publishers:
            if isinstance(publisher, LifecyclePublisher):
                publisher.is_activated = activated
        return _SUCCESS

    def _run_transition(self, transition: int | str) -> TransitionCallbackReturn:
        """Go through a transition with its callback, and return the callback's outcome.

        If the transition does not start from the current state, an error is logged and ERROR
        returned.
        """
        node: Any = self
        before = LifecycleState(LABELS[self._state], self._state)
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

    def _steps(self) -> list[Step]:
        return [step for step in STEPS if step.start == self._state]

    def _call(self, before: LifecycleState) -> TransitionCallbackReturn:
        node: Any = self
        callback = CALLBACKS[self._state]
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
        current = LABELS[self._state]
        raise RCLError(f"Unable to start transition {transition} from current state {current}")

    def _change(self, request: Any, response: Any) -> Any:
        wanted = request.transition.label or request.transition.id
        response.success = self._run_transition(wanted) == _SUCCESS
        return response

    def _tell_state(self, request: Any, response: Any) -> Any:
        response.current_state = _state(self._state)
        return response

    def _tell_states(self, request: Any, response: Any) -> Any:
        response.available_states = [_state(number) for number in LABELS]
        return response

    def _tell_transitions(self, request: Any, response: Any) -> Any:
        response.available_transitions = [_description(s) for s in self._steps()]
        return response

    def _tell_graph(self, request: Any, response: Any) -> Any:
        response.available_transitions = [_description(step) for step in STEPS]
        return response


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
    return State(id=number, label=LABELS[number])


def _description(step: Step) -> TransitionDescription:
    return TransitionDescription(
        transition=Transition(id=step.number, label=step.label),
        start_state=_state(step.start),
        goal_state=_state(step.goal),
    )
