"""The module `rclpy.event_handler`: callbacks for endpoints with incompatible QoS."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, NamedTuple

from rclpy._entity import Endpoint, Entity
from rclpy._rclpy_pybind11 import UnsupportedEventTypeError
from rclpy.callback_groups import CallbackGroup
from rclpy.logging import get_logger
from rclpy.qos import QoSPolicyKind

EventCallback = Callable[[Any], Any] | None


class QoSRequestedIncompatibleQoSInfo(NamedTuple):
    """The numbers of endpoints with incompatible QoS, and the policy in which the last one differs.

    `total_count_change` counts since the last callback. QoSOfferedIncompatibleQoSInfo is this
    class, too.
    """

    total_count: int = 0
    total_count_change: int = 0
    last_policy_kind: QoSPolicyKind = QoSPolicyKind.INVALID


QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo
# No message is lost in one process, and no endpoint of another type is reported.
QoSMessageLostInfo = IncompatibleTypeInfo = NamedTuple(
    "IncompatibleTypeInfo", [("total_count", int), ("total_count_change", int)]
)


class EventHandler(Entity):
    """The handler of endpoints with incompatible QoS, which calls a callback with their number.

    Several before the callback runs make one call.
    """

    _rank = 0

    def __init__(
        self, endpoint: Endpoint, callback_group: CallbackGroup, callback: Callable[[Any], Any]
    ) -> None:
        super().__init__(endpoint._node, callback_group)
        self.callback = callback
        self._lock = threading.Lock()
        self._total = self._reported = 0
        self._policy = QoSPolicyKind.INVALID

    def _count(self, policy: QoSPolicyKind) -> None:
        """Count an endpoint that differs in a policy."""
        with self._lock:
            self._total, self._policy = self._total + 1, policy
        self._notify()

    def _waiting(self) -> int:
        return self._total - self._reported

    def _take(self) -> Callable[[], Any] | None:
        with self._lock:
            change = self._waiting()
            if self._destroyed or not change:
                return None
            self._reported = self._total
            info = QoSRequestedIncompatibleQoSInfo(self._total, change, self._policy)
        return partial(self.callback, info)


class SubscriptionEventCallbacks:
    """The callbacks of a subscription's events, for `Node.create_subscription`.

    Nothing watches deadlines, liveliness and matches here, so callbacks for them raise
    UnsupportedEventTypeError; no message is lost, and no endpoint of another type is reported.
    """

    _said: ClassVar[str] = (
        "New publisher discovered on topic '{}', offering incompatible QoS. "
        "No messages will be received from it."
    )

    def __init__(
        self,
        *,
        deadline: EventCallback = None,
        incompatible_qos: EventCallback = None,
        liveliness: EventCallback = None,
        message_lost: EventCallback = None,
        incompatible_type: EventCallback = None,
        matched: EventCallback = None,
        use_default_callbacks: bool = True,
    ) -> None:
        if deadline or liveliness or matched:
            said = "the embedded engine has no events of deadline, liveliness and matches"
            raise UnsupportedEventTypeError(f"{said}: real ROS 2 has")
        self.incompatible_qos = incompatible_qos
        self.message_lost, self.incompatible_type = message_lost, incompatible_type
        self.use_default_callbacks = use_default_callbacks

    def create_event_handlers(
        self, callback_group: CallbackGroup, endpoint: Any, topic_name: str
    ) -> list[EventHandler]:
        """Return the new handler; by default, it warns of endpoints with incompatible QoS."""
        callback = self.incompatible_qos
        if callback is None and self.use_default_callbacks:
            logger, said = get_logger(endpoint.logger_name), self._said.format(topic_name)

            def callback(event: QoSRequestedIncompatibleQoSInfo) -> None:
                logger.warning(f"{said} Last incompatible policy: {event.last_policy_kind.name}")

        return [] if callback is None else [EventHandler(endpoint, callback_group, callback)]


class PublisherEventCallbacks(SubscriptionEventCallbacks):
    """The callbacks of a publisher's events, for `Node.create_publisher`."""

    _said = (
        "New subscription discovered on topic '{}', requesting incompatible QoS. "
        "No messages will be sent to it."
    )
