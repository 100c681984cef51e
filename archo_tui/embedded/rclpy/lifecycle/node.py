"""The module `rclpy.lifecycle.node`: nodes with states, and services that change them."""

from __future__ import annotations

from typing import Any

from lifecycle_msgs.msg import State, Transition, TransitionDescription, TransitionEvent
from lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from rclpy._rclpy_pybind11 import RCLError
from rclpy.lifecycle._states import (
    LABELS,
    STEPS,
    LifecycleState,
    StateMachine,
    Step,
    TransitionCallbackReturn,
)
from rclpy.lifecycle.managed_entity import ManagedEntity
from rclpy.lifecycle.publisher import LifecyclePublisher
from rclpy.node import Node
from rclpy.publisher import Publisher

__all__ = ["LifecycleNode", "LifecycleNodeMixin", "LifecycleState", "TransitionCallbackReturn"]

_SUCCESS, _ERROR = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.ERROR
_CALLBACKS = {  # By the state in which they run.
    State.TRANSITION_STATE_CONFIGURING: "on_configure",
    State.TRANSITION_STATE_CLEANINGUP: "on_cleanup",
    State.TRANSITION_STATE_ACTIVATING: "on_activate",
    State.TRANSITION_STATE_DEACTIVATING: "on_deactivate",
    State.TRANSITION_STATE_SHUTTINGDOWN: "on_shutdown",
}


class LifecycleNodeMixin(ManagedEntity):
    """A mixin that makes a Node a lifecycle node; it is listed before Node among the bases.

    A node may override the callbacks of ManagedEntity. The callbacks here pass the transition on to
    the managed entities, so an overriding `on_activate` calls the one of this class as well. An
    exception of a callback is logged and counts as ERROR, after which `on_error` is called.
    """

    def __init__(self, *, enable_communication_interface: bool = True) -> None:
        if not isinstance(enable_communication_interface, bool):
            raise TypeError("enable_communication_interface must be a bool")
        self._state_machine = StateMachine()
        self._managed_entities: set[ManagedEntity] = set()
        self._transition_events: Publisher[TransitionEvent] | None = None
        if enable_communication_interface:
            self._offer()

    def _offer(self) -> None:
        node: Any = self
        event = f"{node.get_name()}/transition_event"
        self._transition_events = node.create_publisher(TransitionEvent, event, 10)
        for srv_type, name, callback in (
            (ChangeState, "change_state", self._change),
            (GetState, "get_state", self._tell_state),
            (GetAvailableStates, "get_available_states", self._tell_states),
            (GetAvailableTransitions, "get_available_transitions", self._tell_transitions),
            (GetAvailableTransitions, "get_transition_graph", self._tell_graph),
        ):
            service = node.create_service(srv_type, f"{node.get_name()}/{name}", callback)
            setattr(self, f"_service_{name}", service)
            setattr(self._state_machine, f"service_{name}", service)

    def trigger_configure(self) -> TransitionCallbackReturn:
        """Run `on_configure`, change the state by its outcome, and return the outcome.

        If the node is not `unconfigured`, an error is logged and ERROR returned.
        """
        return self._run_transition("configure")

    def trigger_cleanup(self) -> TransitionCallbackReturn:
        """Run `on_cleanup`, change the state by its outcome, and return the outcome.

        If the node is not `inactive`, an error is logged and ERROR returned.
        """
        return self._run_transition("cleanup")

    def trigger_activate(self) -> TransitionCallbackReturn:
        """Run `on_activate`, change the state by its outcome, and return the outcome.

        If the node is not `inactive`, an error is logged and ERROR returned.
        """
        return self._run_transition("activate")

    def trigger_deactivate(self) -> TransitionCallbackReturn:
        """Run `on_deactivate`, change the state by its outcome, and return the outcome.

        If the node is not `active`, an error is logged and ERROR returned.
        """
        return self._run_transition("deactivate")

    def trigger_shutdown(self) -> TransitionCallbackReturn:
        """Run `on_shutdown`, change the state by its outcome, and return the outcome.

        The state is `finalized` then, unless the outcome is ERROR and `on_error` returns SUCCESS.
        """
        if all(step.label != "shutdown" for step in self._state_machine.steps):
            raise RCLError("Shutdown transtion not possible")  # rclpy's own spelling.
        return self._run_transition("shutdown")

    def add_managed_entity(self, entity: ManagedEntity) -> None:
        """Add an entity, whose callbacks are called at each transition from now on."""
        if not isinstance(entity, ManagedEntity):
            raise TypeError("Expected a rclpy.lifecycle.ManagedEntity instance.")
        self._managed_entities.add(entity)

    def create_lifecycle_publisher(self, *args: Any, **kwargs: Any) -> LifecyclePublisher[Any]:
        """Create a publisher that is silent until the node is activated, and once deactivated.

        The arguments and errors are those of `create_publisher`, without `publisher_class`.
        """
        node: Any = self
        made = node.create_publisher(*args, publisher_class=LifecyclePublisher, **kwargs)
        publisher: LifecyclePublisher[Any] = made
        self._managed_entities.add(publisher)
        return publisher

    def destroy_lifecycle_publisher(self, publisher: LifecyclePublisher[Any]) -> bool:
        """Destroy a lifecycle publisher of this node; return False for any other publisher."""
        self._managed_entities.discard(publisher)
        node: Any = self
        destroyed: bool = node.destroy_publisher(publisher)
        return destroyed

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._pass_on("on_configure", state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._pass_on("on_cleanup", state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._pass_on("on_shutdown", state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._pass_on("on_activate", state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._pass_on("on_deactivate", state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._pass_on("on_error", state)

    def _pass_on(self, callback: str, state: LifecycleState) -> TransitionCallbackReturn:
        """Call a callback of every managed entity, and return SUCCESS.

        The first other outcome ends this and is returned. The order is arbitrary.
        """
        for entity in list(self._managed_entities):
            said: TransitionCallbackReturn = getattr(entity, callback)(state)
            if said != _SUCCESS:
                return said
        return _SUCCESS

    def _run_transition(self, transition: int | str) -> TransitionCallbackReturn:
        """Go through a transition with its callback, and return the callback's outcome."""
        node: Any = self
        number, label = self._state_machine.current_state
        before = LifecycleState(label, number)
        try:
            step = self._take(transition)
        except RCLError as error:
            node.get_logger().error(str(error))
            return _ERROR
        said = self._call(_CALLBACKS[step.goal], before)
        self._take(said.to_label())
        if self._state_machine.current_state[0] == State.TRANSITION_STATE_ERRORPROCESSING:
            self._take(self._call("on_error", before).to_label())
        return said

    def _call(self, callback: str, before: LifecycleState) -> TransitionCallbackReturn:
        node: Any = self
        try:
            said: TransitionCallbackReturn = getattr(self, callback)(before)
        except Exception as error:
            node.get_logger().error(f"{callback}: {type(error).__name__}: {error}")
            return _ERROR
        return said

    def _take(self, transition: int | str) -> Step:
        step = self._state_machine.trigger_transition(transition)
        if self._transition_events is not None:
            # rcl publishes it without its time and the transition's name.
            start, goal = _state(step.start), _state(step.goal)
            self._transition_events.publish(TransitionEvent(start_state=start, goal_state=goal))
        return step

    def _change(self, request: Any, response: Any) -> Any:
        response.success = (
            self._run_transition(request.transition.label or request.transition.id) == _SUCCESS
        )
        return response

    def _tell_state(self, request: Any, response: Any) -> Any:
        response.current_state = _state(self._state_machine.current_state[0])
        return response

    def _tell_states(self, request: Any, response: Any) -> Any:
        response.available_states = [_state(number) for number in LABELS]
        return response

    def _tell_transitions(self, request: Any, response: Any) -> Any:
        response.available_transitions = [_description(s) for s in self._state_machine.steps]
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
