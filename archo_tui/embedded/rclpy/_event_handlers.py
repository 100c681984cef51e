"""The kinds of events of an endpoint with the data of each, and what tells its callbacks."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from rclpy._entity import Destroyable, Entity
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSPolicyKind, QoSProfile

if TYPE_CHECKING:
    from rclpy.node import Node


class QoSPublisherEventType(IntEnum):
    """The kinds of events of a publisher."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class QoSSubscriptionEventType(IntEnum):
    """The kinds of events of a subscription."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


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


class QoSMessageLostInfo(NamedTuple):
    """The lost messages: all, and those since the last callback; here no message is ever lost."""

    total_count: int = 0
    total_count_change: int = 0


class IncompatibleTypeInfo(NamedTuple):
    """The endpoints of another type in all and since the last callback; here none is reported."""

    total_count: int = 0
    total_count_change: int = 0


QoSPublisherMatchedInfo = QoSSubscriptionMatchedInfo
QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo


class Endpoint(Destroyable):
    """The base of publishers and subscriptions, with the handlers of their events."""

    _node: Node
    qos_profile: QoSProfile
    event_handlers: Sequence[EventHandler] = ()

    def _forget_events(self) -> None:
        for handler in self.event_handlers:
            handler.destroy()


class EventHandler(Entity):
    """The handler of one kind of event, which calls a callback with the newest counts.

    Several events before the callback runs make one call. This base itself never calls back: it
    serves for lost messages, which do not occur within one process, and for endpoints of other
    types, which Fast DDS does not report either.
    """

    _rank = 0

    def __init__(
        self,
        endpoint: Endpoint,
        callback_group: CallbackGroup,
        callback: Callable[[Any], Any],
        event_type: IntEnum,
    ) -> None:
        super().__init__(endpoint._node, callback_group)
        self.callback, self.event_type = callback, event_type
        self._lock = threading.Lock()
        self._has_news = False
        self._total = self._reported = 0

    def _waiting(self) -> int:
        return int(self._has_news)

    def _take(self) -> Callable[[], Any] | None:
        with self._lock:
            if self._destroyed or not self._has_news:
                return None
            self._has_news = False
            return partial(self.callback, self._info())

    def _info(self) -> Any:
        """Return the counts for the callback; the next changes are counted from here."""
        raise NotImplementedError

    def _change(self) -> int:
        """Return how much the total has grown since the last call."""
        change, self._reported = self._total - self._reported, self._total
        return change

    # what may happen to an endpoint

    def _count_match(self, change: int) -> None:
        """Count a match that came (1) or ended (-1); this base ignores it."""

    def _count_incompatible(self, policy: QoSPolicyKind) -> None:
        """Count an endpoint whose QoS does not match, by that policy; this base ignores it."""


class Matched(EventHandler):
    """The handler that counts the endpoints that match, and calls back when one comes or goes."""

    _current = _reported_current = 0

    def _count_match(self, change: int) -> None:
        with self._lock:
            self._current += change
            self._total += max(change, 0)
            self._has_news = True
        self._notify()

    def _info(self) -> QoSSubscriptionMatchedInfo:
        current, self._reported_current = self._current - self._reported_current, self._current
        return QoSSubscriptionMatchedInfo(self._total, self._change(), self._current, current)


class IncompatibleQoS(EventHandler):
    """The handler that counts endpoints with incompatible QoS, and keeps the last one's policy."""

    _policy = QoSPolicyKind.INVALID

    def _count_incompatible(self, policy: QoSPolicyKind) -> None:
        with self._lock:
            self._total += 1
            self._policy = policy
            self._has_news = True
        self._notify()

    def _info(self) -> QoSRequestedIncompatibleQoSInfo:
        return QoSRequestedIncompatibleQoSInfo(self._total, self._change(), self._policy)
