"""The module `rclpy.event_handler`: callbacks for the events of an endpoint."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any

from rclpy import _event_handlers as handlers
from rclpy._event_handlers import EventHandler
from rclpy._event_infos import (
    IncompatibleTypeInfo,
    QoSMessageLostInfo,
    QoSOfferedIncompatibleQoSInfo,
    QoSPublisherEventType,
    QoSPublisherMatchedInfo,
    QoSRequestedIncompatibleQoSInfo,
    QoSSubscriptionEventType,
    QoSSubscriptionMatchedInfo,
)
from rclpy._rclpy_pybind11 import UnsupportedEventTypeError
from rclpy.callback_groups import CallbackGroup
from rclpy.logging import get_logger
from rclpy.qos import qos_policy_name_from_kind

__all__ = [
    "EventHandler",
    "IncompatibleTypeInfo",
    "PublisherEventCallbacks",
    "QoSMessageLostInfo",
    "QoSOfferedIncompatibleQoSInfo",
    "QoSPublisherEventType",
    "QoSPublisherMatchedInfo",
    "QoSRequestedIncompatibleQoSInfo",
    "QoSSubscriptionEventType",
    "QoSSubscriptionMatchedInfo",
    "SubscriptionEventCallbacks",
    "UnsupportedEventTypeError",
]

EventCallback = Callable[[Any], Any] | None
Kind = tuple[IntEnum, type[EventHandler], EventCallback]


class SubscriptionEventCallbacks:
    """The callbacks of a subscription's events, for `Node.create_subscription`."""

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
        """Set the callbacks, each called with an info such as QoSSubscriptionMatchedInfo."""
        self.deadline = deadline
        self.incompatible_qos = incompatible_qos
        self.liveliness = liveliness
        self.message_lost = message_lost
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks

    def create_event_handlers(
        self, callback_group: CallbackGroup, subscription: Any, topic_name: str
    ) -> list[EventHandler]:
        """Return new handlers, one for each callback that is set or that is a default.

        Defaults are used for `incompatible_qos` and `incompatible_type`, if `use_default_callbacks`
        is True.
        """
        _refuse_timed(self)
        event, qos, kind = QoSSubscriptionEventType, self.incompatible_qos, self.incompatible_type
        if self.use_default_callbacks:
            said = f"New publisher discovered on topic '{topic_name}', offering incompatible QoS. "
            said += "No messages will be received from it."
            qos = qos or _warns_of_qos(subscription, said)
            kind = kind or _is_never_called
        kinds: list[Kind] = [
            (event.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS, handlers.IncompatibleQoS, qos),
            (event.RCL_SUBSCRIPTION_MESSAGE_LOST, EventHandler, self.message_lost),
            (event.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE, EventHandler, kind),
            (event.RCL_SUBSCRIPTION_MATCHED, handlers.Matched, self.matched),
        ]
        return _make_handlers(kinds, subscription, callback_group)


class PublisherEventCallbacks:
    """The callbacks of a publisher's events, for `Node.create_publisher`."""

    def __init__(
        self,
        *,
        deadline: EventCallback = None,
        liveliness: EventCallback = None,
        incompatible_qos: EventCallback = None,
        incompatible_type: EventCallback = None,
        matched: EventCallback = None,
        use_default_callbacks: bool = True,
    ) -> None:
        """Set the callbacks, each called with an info such as QoSPublisherMatchedInfo."""
        self.deadline = deadline
        self.liveliness = liveliness
        self.incompatible_qos = incompatible_qos
        self.incompatible_type = incompatible_type
        self.matched = matched
        self.use_default_callbacks = use_default_callbacks

    def create_event_handlers(
        self, callback_group: CallbackGroup, publisher: Any, topic_name: str
    ) -> list[EventHandler]:
        """Return new handlers, one for each callback that is set or that is a default.

        Defaults are used for `incompatible_qos` and `incompatible_type`, if `use_default_callbacks`
        is True.
        """
        _refuse_timed(self)
        event, qos, kind = QoSPublisherEventType, self.incompatible_qos, self.incompatible_type
        if self.use_default_callbacks:
            said = f"New subscription discovered on topic '{topic_name}', requesting incompatible "
            said += "QoS. No messages will be sent to it."
            qos = qos or _warns_of_qos(publisher, said)
            kind = kind or _is_never_called
        kinds: list[Kind] = [
            (event.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS, handlers.IncompatibleQoS, qos),
            (event.RCL_PUBLISHER_INCOMPATIBLE_TYPE, EventHandler, kind),
            (event.RCL_PUBLISHER_MATCHED, handlers.Matched, self.matched),
        ]
        return _make_handlers(kinds, publisher, callback_group)


def _refuse_timed(callbacks: SubscriptionEventCallbacks | PublisherEventCallbacks) -> None:
    """Raise UnsupportedEventTypeError if a callback for deadline or liveliness is set."""
    for name in ("deadline", "liveliness"):
        if getattr(callbacks, name):
            where = f"{type(callbacks).__name__}({name}=...)"
            raise UnsupportedEventTypeError(
                f"the embedded engine has no {where}: real ROS 2 has it"
            )


def _make_handlers(kinds: list[Kind], endpoint: Any, group: CallbackGroup) -> list[EventHandler]:
    return [kind(endpoint, group, callback, event) for event, kind, callback in kinds if callback]


def _warns_of_qos(endpoint: Any, said: str) -> Callable[[Any], None]:
    logger = get_logger(endpoint.logger_name)

    def _default_incompatible_qos_callback(event: QoSRequestedIncompatibleQoSInfo) -> None:
        policy = qos_policy_name_from_kind(event.last_policy_kind)
        logger.warn(f"{said} Last incompatible policy: {policy}")

    return _default_incompatible_qos_callback


def _is_never_called(_: IncompatibleTypeInfo) -> None:
    """Do nothing: the default callback for other types, of which no endpoint is told."""
