"""`rclpy.event_handler`: told when an endpoint meets another, or cannot.

Deadlines, liveliness and losses are not watched in one process: asking to be told of them raises
UnsupportedEventTypeError, as on a middleware that does not.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

from rclpy._entity import QueueEntity
from rclpy._rclpy_pybind11 import UnsupportedEventTypeError
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSPolicyKind

if TYPE_CHECKING:
    from rclpy.node import Node

__all__ = [
    "IncompatibleTypeInfo",
    "PublisherEventCallbacks",
    "QoSLivelinessChangedInfo",
    "QoSLivelinessLostInfo",
    "QoSMessageLostInfo",
    "QoSOfferedDeadlineMissedInfo",
    "QoSOfferedIncompatibleQoSInfo",
    "QoSPublisherEventType",
    "QoSPublisherMatchedInfo",
    "QoSRequestedDeadlineMissedInfo",
    "QoSRequestedIncompatibleQoSInfo",
    "QoSSubscriptionEventType",
    "QoSSubscriptionMatchedInfo",
    "SubscriptionEventCallbacks",
    "UnsupportedEventTypeError",
]


class QoSPublisherEventType(IntEnum):
    """What a publisher can be told of."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class QoSSubscriptionEventType(IntEnum):
    """What a subscription can be told of."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


class QoSSubscriptionMatchedInfo(NamedTuple):
    """How many endpoints match now and did in all, and what has changed since the last event."""

    total_count: int
    total_count_change: int
    current_count: int
    current_count_change: int


class QoSRequestedIncompatibleQoSInfo(NamedTuple):
    """How many endpoints did not match, and for which policy the last one."""

    total_count: int
    total_count_change: int
    last_policy_kind: QoSPolicyKind


class QoSMessageLostInfo(NamedTuple):
    """How many messages were lost."""

    total_count: int
    total_count_change: int


class QoSRequestedDeadlineMissedInfo(NamedTuple):
    """How many deadlines were missed."""

    total_count: int
    total_count_change: int


class QoSLivelinessChangedInfo(NamedTuple):
    """How many publishers are alive."""

    alive_count: int
    not_alive_count: int
    alive_count_change: int
    not_alive_count_change: int


class IncompatibleTypeInfo(NamedTuple):
    """How many endpoints of another type there are."""

    total_count: int
    total_count_change: int


QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo
QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo
QoSOfferedDeadlineMissedInfo = QoSRequestedDeadlineMissedInfo
QoSLivelinessLostInfo = QoSMessageLostInfo

Told = Callable[[Any], None] | None


class EventCallbacks:
    """Callbacks of an endpoint; those that nothing calls here are refused when it is made."""

    def __init__(
        self, matched: Told, incompatible_qos: Told, use_default: bool, **unwatched: Told
    ) -> None:
        self.matched, self.incompatible_qos = matched, incompatible_qos
        self.use_default_callbacks = use_default
        self._unwatched = unwatched
        vars(self).update(unwatched)

    def check(self) -> None:
        """Raises UnsupportedEventTypeError for an event that this engine does not watch."""
        for name, callback in self._unwatched.items():
            if callback is not None:
                raise UnsupportedEventTypeError(f"the embedded engine has no {name} event")


class SubscriptionEventCallbacks(EventCallbacks):
    """What a subscription is told."""

    def __init__(
        self,
        *,
        deadline: Told = None,
        incompatible_qos: Told = None,
        liveliness: Told = None,
        message_lost: Told = None,
        incompatible_type: Told = None,
        matched: Told = None,
        use_default_callbacks: bool = True,
    ) -> None:
        super().__init__(
            matched,
            incompatible_qos,
            use_default_callbacks,
            deadline=deadline,
            liveliness=liveliness,
            message_lost=message_lost,
            incompatible_type=incompatible_type,
        )


class PublisherEventCallbacks(EventCallbacks):
    """What a publisher is told."""

    def __init__(
        self,
        *,
        deadline: Told = None,
        liveliness: Told = None,
        incompatible_qos: Told = None,
        incompatible_type: Told = None,
        matched: Told = None,
        use_default_callbacks: bool = True,
    ) -> None:
        super().__init__(
            matched,
            incompatible_qos,
            use_default_callbacks,
            deadline=deadline,
            liveliness=liveliness,
            incompatible_type=incompatible_type,
        )


class EventHandler(QueueEntity):
    """Hands the newest event of one kind to its callback, with what came since the last one."""

    def __init__(
        self, node: Node, callback: Callable[[Any], None], callback_group: CallbackGroup
    ) -> None:
        super().__init__(node, callback_group, 1)
        self.callback = callback
        self._total = self._told_total = self._current = self._told_current = 0
        self._policy = QoSPolicyKind.INVALID

    def _met(self, change: int) -> None:
        """Another endpoint came (1) or left (-1)."""
        self._current += change
        self._total += max(change, 0)
        self._deliver(True)

    def _refused(self, policy: QoSPolicyKind) -> None:
        """Another endpoint does not match."""
        self._total += 1
        self._policy = policy
        self._deliver(False)

    def _handle(self, item: bool) -> Any:
        total, current = self._total - self._told_total, self._current - self._told_current
        self._told_total, self._told_current = self._total, self._current
        if item:
            info: Any = QoSSubscriptionMatchedInfo(self._total, total, self._current, current)
        else:
            info = QoSRequestedIncompatibleQoSInfo(self._total, total, self._policy)
        return self.callback(info)
