"""`rclpy.service_introspection`: the calls of a service, told on `<service>/_service_event`."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any

from rclpy._entity import Destroyable
from rclpy.clock import Clock
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

if TYPE_CHECKING:
    from rclpy.node import Node

# of service_msgs/msg/ServiceEventInfo, which few programs need
REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT, RESPONSE_RECEIVED = range(4)


class ServiceIntrospectionState(IntEnum):
    """What is told of each call: nothing, that it was made, or also what was asked and answered."""

    OFF = 0
    METADATA = 1
    CONTENTS = 2


class ServiceEnd(Destroyable):
    """A client or a service: its name, and what tells of its calls."""

    _node: Node
    _service_name: str
    srv_type: Any
    _clock: Clock
    _state = ServiceIntrospectionState.OFF
    _events: Publisher[Any] | None = None

    @property
    def service_name(self) -> str:
        """Its name on the graph. Raises InvalidHandle after `destroy()`."""
        self._use()
        return self._service_name

    @property
    def logger_name(self) -> str:
        """The name of its node's logger."""
        return self._node.get_logger().name

    def configure_introspection(
        self,
        clock: Clock,
        service_event_qos_profile: QoSProfile,
        introspection_state: ServiceIntrospectionState,
    ) -> None:
        """Tell of calls from now on, with the clock's time, or no longer.

        Raises InvalidHandle after `destroy()`; AttributeError for another clock or profile,
        TypeError for another state.
        """
        self._use()
        for value, kind, error in (
            (clock, Clock, AttributeError),
            (service_event_qos_profile, QoSProfile, AttributeError),
            (introspection_state, ServiceIntrospectionState, TypeError),
        ):
            if not isinstance(value, kind):
                raise error(f"configure_introspection(): {value!r} is no {kind.__name__}")
        self._end_introspection()
        self._clock, self._state = clock, introspection_state
        if introspection_state != ServiceIntrospectionState.OFF:
            name = f"{self._service_name}/_service_event"
            qos = service_event_qos_profile
            self._events = Publisher(self._node, self.srv_type.Event, name, name, qos)
            self._node._graph.add_publisher(self._events)

    def _end_introspection(self) -> None:
        if self._events is not None:
            self._events.destroy()
            self._events = None

    def _tell(self, event_type: int, client_gid: list[int], number: int, **contents: Any) -> None:
        """Publish one event; `contents` are its `request` or `response`."""
        events = self._events
        if events is None:  # another thread may have ended it since the caller looked
            return
        event = self.srv_type.Event()
        event.info.event_type = event_type
        event.info.stamp = self._clock.now().to_msg()
        event.info.client_gid = client_gid
        event.info.sequence_number = number
        if self._state == ServiceIntrospectionState.CONTENTS:
            for name, message in contents.items():
                setattr(event, name, [message])
        events.publish(event)
