"""The handlers that tell an endpoint's callbacks of events."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING, Any

from rclpy._entity import Destroyable, Entity
from rclpy._event_infos import QoSRequestedIncompatibleQoSInfo, QoSSubscriptionMatchedInfo
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSPolicyKind, QoSProfile

if TYPE_CHECKING:
    from rclpy.node import Node


class Endpoint(Destroyable):
    """A publisher or subscription, with the handlers that tell its callbacks of events."""

    _node: Node
    qos_profile: QoSProfile
    event_handlers: Sequence[EventHandler] = ()

    def _forget_events(self) -> None:
        for handler in self.event_handlers:
            handler.destroy()


class EventHandler(Entity):
    """A handler that hands the newest state of an event to its callback; this base has no events.

    It serves for lost messages, of which there are none in one process, and for other types, of
    which Fast DDS does not tell either.
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
        self._total = self._told = 0

    def _waiting(self) -> int:
        return int(self._has_news)

    def _take(self) -> Callable[[], Any] | None:
        with self._lock:
            if self._destroyed or not self._has_news:
                return None
            self._has_news = False
            return partial(self.callback, self._info())

    def _info(self) -> Any:
        """Return what the callback is given, and count it as told."""
        raise NotImplementedError

    def _change(self) -> int:
        """Return how much of the total is new."""
        change, self._told = self._total - self._told, self._total
        return change

    # what may happen to an endpoint

    def _met(self, change: int) -> None:
        """Count a matching endpoint that came (1) or left (-1)."""

    def _refused(self, policy: QoSPolicyKind) -> None:
        """Count an endpoint that does not match."""


class Matched(EventHandler):
    """A handler of endpoints that match."""

    _current = _told_current = 0

    def _met(self, change: int) -> None:
        with self._lock:
            self._current += change
            self._total += max(change, 0)
            self._has_news = True
        self._notify()

    def _info(self) -> QoSSubscriptionMatchedInfo:
        current, self._told_current = self._current - self._told_current, self._current
        return QoSSubscriptionMatchedInfo(self._total, self._change(), self._current, current)


class IncompatibleQoS(EventHandler):
    """A handler of endpoints that do not match."""

    _policy = QoSPolicyKind.INVALID

    def _refused(self, policy: QoSPolicyKind) -> None:
        with self._lock:
            self._total += 1
            self._policy = policy
            self._has_news = True
        self._notify()

    def _info(self) -> QoSRequestedIncompatibleQoSInfo:
        return QoSRequestedIncompatibleQoSInfo(self._total, self._change(), self._policy)
