"""The module `rclpy.event_handler`: callbacks for the events of an endpoint."""

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


class QoSSubscriptionMatchedInfo(NamedTuple):
    """The numbers of endpoints that have matched in all, and that match now.

    A `..._change` counts since the last callback; `current_count_change` is negative if fewer match
    now. QoSPublisherMatchedInfo is this class, too.
    """

    total_count: int = 0
    total_count_change: int = 0
    current_count: int = 0
    current_count_change: int = 0


class QoSRequestedIncompatibleQoSInfo(NamedTuple):
    """The numbers of endpoints with incompatible QoS, and the policy in which the last one differs.

    `total_count_change` counts since the last callback. QoSOfferedIncompatibleQoSInfo is this
    class, too.
    """

    total_count: int = 0
    total_count_change: int = 0
    last_policy_kind: QoSPolicyKind = QoSPolicyKind.INVALID


class IncompatibleTypeInfo(NamedTuple):
    """The endpoints of another type in all and since the last callback; here none is reported."""

    total_count: int = 0
    total_count_change: int = 0


QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo
QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo
QoSMessageLostInfo = IncompatibleTypeInfo  # Of the same form; no message is lost in one process.


class EventHandler(Entity):
    """The handler of one kind of event, which calls a callback with the newest counts.

    Several events before the callback runs make one call.
    """

    _rank = 0

    def __init__(
        self,
        endpoint: Endpoint,
        callback_group: CallbackGroup,
        callback: Callable[[Any], Any],
        counts_matches: bool,
    ) -> None:
        super().__init__(endpoint._node, callback_group)
        self.callback, self._counts_matches = callback, counts_matches
        self._lock = threading.Lock()
        self._has_news = False
        self._total = self._current = self._reported = self._reported_current = 0
        self._policy = QoSPolicyKind.INVALID

    def _count(self, change: int, policy: QoSPolicyKind | None = None) -> None:
        """Count an endpoint that matches (1), no longer does (-1), or differs in a policy."""
        if self._counts_matches != (policy is None):
            return
        with self._lock:
            self._current += change
            self._total += max(change, 0)
            self._policy, self._has_news = policy or self._policy, True
        self._notify()

    def _waiting(self) -> int:
        return int(self._has_news)

    def _take(self) -> Callable[[], Any] | None:
        with self._lock:
            if self._destroyed or not self._has_news:
                return None
            self._has_news = False
            total, current = self._total, self._current
            change, current_change = total - self._reported, current - self._reported_current
            self._reported, self._reported_current = total, current
            info: Any = QoSRequestedIncompatibleQoSInfo(total, change, self._policy)
            if self._counts_matches:
                info = QoSSubscriptionMatchedInfo(total, change, current, current_change)
        return partial(self.callback, info)


class SubscriptionEventCallbacks:
    """The callbacks of a subscription's events, for `Node.create_subscription`.

    Each is called with an info such as QoSSubscriptionMatchedInfo. Nothing watches deadlines and
    liveliness here, so callbacks for them raise UnsupportedEventTypeError; no message is lost, and
    no endpoint of another type is reported.
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
        if deadline or liveliness:
            said = "the embedded engine has no events of deadline and liveliness: real ROS 2 has"
            raise UnsupportedEventTypeError(said)
        self.incompatible_qos, self.matched = incompatible_qos, matched
        self.message_lost, self.incompatible_type = message_lost, incompatible_type
        self.use_default_callbacks = use_default_callbacks

    def create_event_handlers(
        self, callback_group: CallbackGroup, endpoint: Any, topic_name: str
    ) -> list[EventHandler]:
        """Return new handlers; by default, one warns of endpoints with incompatible QoS."""
        on_qos = self.incompatible_qos
        if on_qos is None and self.use_default_callbacks:
            logger, said = get_logger(endpoint.logger_name), self._said.format(topic_name)

            def on_qos(event: QoSRequestedIncompatibleQoSInfo) -> None:
                logger.warning(f"{said} Last incompatible policy: {event.last_policy_kind.name}")

        return [
            EventHandler(endpoint, callback_group, callback, counts_matches)
            for callback, counts_matches in ((on_qos, False), (self.matched, True))
            if callback is not None
        ]


class PublisherEventCallbacks(SubscriptionEventCallbacks):
    """The callbacks of a publisher's events, for `Node.create_publisher`."""

    _said = (
        "New subscription discovered on topic '{}', requesting incompatible QoS. "
        "No messages will be sent to it."
    )
