"""`rclpy.parameter_event_handler`: told when parameters of any node change."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterEvent
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile, qos_profile_parameter_events

if TYPE_CHECKING:
    from rclpy.node import Node


class ParameterCallbackHandle(NamedTuple):
    """One parameter that is followed."""

    parameter_name: str
    node_name: str
    callback: Callable[[Any], None]


class ParameterEventCallbackHandle(NamedTuple):
    """A follower of every change."""

    callback: Callable[[ParameterEvent], None]


class ParameterEventHandler:
    """Hands the events of /parameter_events to those who follow them; the newest follower first."""

    class Callbacks:
        """Those who follow."""

        def __init__(self) -> None:
            self.parameter_callbacks: dict[tuple[str, str], list[ParameterCallbackHandle]] = {}
            self.event_callbacks: list[ParameterEventCallbackHandle] = []

        def event_callback(self, event: ParameterEvent) -> None:
            """Tell them."""
            for (name, node_name), handles in list(self.parameter_callbacks.items()):
                told = ParameterEventHandler.get_parameter_from_event(event, name, node_name)
                if told is not None:
                    for handle in list(handles):
                        handle.callback(told)
            for follower in list(self.event_callbacks):
                follower.callback(event)

    def __init__(
        self,
        node: Node,
        qos_profile: QoSProfile = qos_profile_parameter_events,
        callback_group: CallbackGroup | None = None,
        **options: Any,
    ) -> None:
        """`options` are those of `create_subscription`."""
        self.node = node
        self.qos_profile = qos_profile
        self._callbacks = self.Callbacks()
        self.parameter_event_subscription = node.create_subscription(
            ParameterEvent,
            "/parameter_events",
            self._callbacks.event_callback,
            qos_profile,
            callback_group=callback_group,
            **options,
        )

    def destroy(self) -> None:
        """Follow nothing any more."""
        self.node.destroy_subscription(self.parameter_event_subscription)

    def add_parameter_callback(
        self, parameter_name: str, node_name: str, callback: Callable[[Any], None]
    ) -> ParameterCallbackHandle:
        """Call with the parameter's message when it is new or changes. Keep what is returned."""
        about = parameter_name, self._resolve_path(node_name)
        handle = ParameterCallbackHandle(*about, callback)
        self._callbacks.parameter_callbacks.setdefault(about, []).insert(0, handle)
        return handle

    def remove_parameter_callback(self, handle: ParameterCallbackHandle) -> None:
        """Raises RuntimeError when it was not added."""
        known = self._callbacks.parameter_callbacks
        about = handle.parameter_name, handle.node_name
        _remove(known.get(about, []), handle)
        if not known[about]:
            del known[about]

    def add_parameter_event_callback(
        self, callback: Callable[[ParameterEvent], None]
    ) -> ParameterEventCallbackHandle:
        """Call with every event. Keep what is returned."""
        handle = ParameterEventCallbackHandle(callback)
        self._callbacks.event_callbacks.insert(0, handle)
        return handle

    def remove_parameter_event_callback(self, handle: ParameterEventCallbackHandle) -> None:
        """Raises RuntimeError when it was not added."""
        _remove(self._callbacks.event_callbacks, handle)

    @staticmethod
    def get_parameter_from_event(
        event: ParameterEvent, parameter_name: str, node_name: str
    ) -> ParameterMsg | None:
        """The new value of a parameter, None when the event is not about it."""
        if event.node != node_name:
            return None
        told = ParameterEventHandler.get_parameters_from_event(event)
        return next((p for p in told if p.name == parameter_name), None)

    @staticmethod
    def get_parameters_from_event(event: ParameterEvent) -> Iterable[ParameterMsg]:
        """The parameters that are new, then those that changed."""
        return [*event.new_parameters, *event.changed_parameters]

    def _resolve_path(self, node_name: str = "") -> str:
        if not node_name:
            return self.node.get_fully_qualified_name()
        if node_name.startswith("/"):
            return node_name
        return f"{self.node.get_namespace().rstrip('/')}/{node_name}"


def _remove(known: list[Any], handle: Any) -> None:
    for place, other in enumerate(known):
        if other is handle:
            del known[place]
            return
    raise RuntimeError("Callback doesn't exist")
