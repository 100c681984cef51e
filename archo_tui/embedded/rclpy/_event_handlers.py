"""Who tells an endpoint's callbacks of events.

Nobody watches the time in between: a period that went by is counted when the next message comes,
or when the executor looks, whichever is first.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING, Any

from rclpy import _time_source
from rclpy._entity import Destroyable, Entity, TimedEntity
from rclpy._event_infos import (
    QoSLivelinessChangedInfo,
    QoSLivelinessLostInfo,
    QoSOfferedDeadlineMissedInfo,
    QoSRequestedDeadlineMissedInfo,
    QoSRequestedIncompatibleQoSInfo,
    QoSSubscriptionMatchedInfo,
)
from rclpy.callback_groups import CallbackGroup
from rclpy.duration import Duration
from rclpy.qos import LivelinessPolicy, QoSPolicyKind, QoSProfile

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.publisher import Publisher


_NEVER_NS = 2**62  # 146 years


class Endpoint(Destroyable):
    """A publisher or subscription, and who tells its callbacks of what happens to it."""

    _node: Node
    qos_profile: QoSProfile
    event_handlers: Sequence[EventHandler] = ()
    _watchers: tuple[EventHandler, ...] = ()  # those that each message is of interest to

    def _hear(self, handlers: Sequence[EventHandler]) -> None:
        self.event_handlers = handlers
        self._watchers = tuple(one for one in handlers if isinstance(one, Timed))

    def _forget_events(self) -> None:
        for handler in self.event_handlers:
            handler.destroy()


class EventHandler(Entity):
    """Hands the newest state of one kind to its callback. This one is told nothing.

    So it is for lost messages, of which there are none in one process, and for other types, of
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
        """What the callback is given; what it tells of is not new from now on."""
        raise NotImplementedError

    def _change(self) -> int:
        """How much of the total is new."""
        change, self._told = self._total - self._told, self._total
        return change

    # what may happen to an endpoint

    def _met(self, change: int) -> None:
        """Another endpoint that matches came (1) or left (-1)."""

    def _refused(self, policy: QoSPolicyKind) -> None:
        """Another endpoint came that does not match."""

    def _sample(self, publisher: Publisher[Any]) -> None:
        """It publishes, or receives, a message."""

    def _asserted(self, publisher: Publisher[Any]) -> None:
        """The publisher says that it is alive."""

    def _gone(self, publisher: Publisher[Any]) -> None:
        """A publisher that matched is gone."""


class Matched(EventHandler):
    """Told of endpoints that match."""

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
    """Told of endpoints that do not match."""

    _policy = QoSPolicyKind.INVALID

    def _refused(self, policy: QoSPolicyKind) -> None:
        with self._lock:
            self._total += 1
            self._policy = policy
            self._has_news = True
        self._notify()

    def _info(self) -> QoSRequestedIncompatibleQoSInfo:
        return QoSRequestedIncompatibleQoSInfo(self._total, self._change(), self._policy)


class Timed(EventHandler, TimedEntity):
    """Told of what does not happen in time."""

    _is_scheduled = False  # the executor is to look again, at `_next_ns`

    def _due(self) -> int | None:
        """When (ns) what is waited for is late, None while nothing is."""
        raise NotImplementedError

    def _lapse(self, now: int) -> None:
        """Count what is late by now."""
        raise NotImplementedError

    def _count(self) -> int:
        """Count what is late; returns the time (ns). The lock is held."""
        now = _time_source.monotonic_ns()
        due = self._due()
        if due is not None and now >= due:
            self._lapse(now)
            self._has_news = True
        return now

    def _is_due(self) -> bool:
        return not self._destroyed

    def _take(self) -> Callable[[], Any] | None:
        with self._lock:
            now = self._count()
        if now >= self._next_ns:  # else the executor is to look again already
            self._schedule()
        return super()._take()

    def _schedule(self) -> None:
        """Have the executor look when something is late."""
        with self._lock:
            due = self._due()
        executor = self._node.executor
        self._is_scheduled = executor is not None and due is not None
        if executor is not None and due is not None:
            self._next_ns = due
            executor._add_timer(self)

    def _arm(self) -> None:
        """After a change: one look is enough, it finds what is late by then."""
        if self._has_news:
            self._notify()
        elif not self._is_scheduled:
            self._schedule()


class DeadlineMissed(Timed):
    """Told when a period of the deadline goes by without a message, from the first one on."""

    _kind: Callable[[int, int], Any] = QoSRequestedDeadlineMissedInfo

    def __init__(self, endpoint: Endpoint, *args: Any) -> None:
        super().__init__(endpoint, *args)
        self._period = _finite_ns(endpoint.qos_profile.deadline)
        self._due_ns: int | None = None

    def _due(self) -> int | None:
        return self._due_ns

    def _sample(self, publisher: Publisher[Any]) -> None:
        if self._period:
            with self._lock:
                self._due_ns = self._count() + self._period
            self._arm()

    def _lapse(self, now: int) -> None:
        assert self._due_ns is not None
        missed = (now - self._due_ns) // self._period + 1
        self._total += missed
        self._due_ns += missed * self._period

    def _info(self) -> Any:
        return type(self)._kind(self._total, self._change())


class OfferedDeadlineMissed(DeadlineMissed):
    """The same, of a publisher."""

    _kind = QoSOfferedDeadlineMissedInfo


class LivelinessLost(Timed):
    """Told when the publisher has not said in time that it is alive: only MANUAL_BY_TOPIC must."""

    def __init__(self, endpoint: Endpoint, *args: Any) -> None:
        super().__init__(endpoint, *args)
        qos = endpoint.qos_profile
        manual = qos.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
        self._lease = _finite_ns(qos.liveliness_lease_duration) if manual else 0
        self._until: int | None = None

    def _due(self) -> int | None:
        return self._until

    def _asserted(self, publisher: Publisher[Any]) -> None:
        if self._lease:
            with self._lock:
                self._until = self._count() + self._lease
            self._arm()

    _sample = _asserted

    def _lapse(self, now: int) -> None:
        self._total += 1
        self._until = None

    def _info(self) -> QoSLivelinessLostInfo:
        return QoSLivelinessLostInfo(self._total, self._change())


class LivelinessChanged(Timed):
    """Told which of its publishers are alive.

    As Fast DDS has it within one process, only a subscription with a lease knows, and a publisher
    is alive from its first message on.
    """

    def __init__(self, endpoint: Endpoint, *args: Any) -> None:
        super().__init__(endpoint, *args)
        self._lease = _finite_ns(endpoint.qos_profile.liveliness_lease_duration)
        self._alive: dict[Publisher[Any], int] = {}  # until when (ns)
        self._silent: set[Publisher[Any]] = set()
        self._told_counts = (0, 0)

    def _due(self) -> int | None:
        return min(self._alive.values(), default=None)

    def _sample(self, publisher: Publisher[Any]) -> None:
        if self._lease:
            with self._lock:
                now = self._count()
                self._has_news |= publisher not in self._alive
                self._silent.discard(publisher)
                self._alive[publisher] = now + self._lease
            self._arm()

    def _asserted(self, publisher: Publisher[Any]) -> None:
        if publisher.qos_profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC:
            self._sample(publisher)

    def _gone(self, publisher: Publisher[Any]) -> None:
        with self._lock:
            self._count()
            if publisher in self._silent or publisher in self._alive:
                self._silent.discard(publisher)
                self._alive.pop(publisher, None)
                self._has_news = True
        self._arm()

    def _lapse(self, now: int) -> None:
        for publisher in [one for one, until in self._alive.items() if until <= now]:
            del self._alive[publisher]
            self._silent.add(publisher)

    def _info(self) -> QoSLivelinessChangedInfo:
        alive, silent = len(self._alive), len(self._silent)
        before, self._told_counts = self._told_counts, (alive, silent)
        return QoSLivelinessChangedInfo(alive, silent, alive - before[0], silent - before[1])


def _finite_ns(duration: Duration) -> int:
    """0 for what never ends: none, Infinite, "best available"."""
    return duration.nanoseconds if duration.nanoseconds < _NEVER_NS else 0
