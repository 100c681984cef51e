"""The module `rclpy.publisher`."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rclpy._entity import Endpoint
from rclpy._time_source import monotonic_ns
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy
from rclpy.serialization import deserialize_message

if TYPE_CHECKING:
    from rclpy.subscription import Subscription

MsgT = TypeVar("MsgT")


class Publisher(Endpoint, Generic[MsgT]):
    """A publisher of messages on one topic, made by `Node.create_publisher`."""

    def __init__(self, *endpoint: Any) -> None:
        super().__init__(*endpoint)
        qos_profile = self.qos_profile
        self._sent = 0
        self._matched: tuple[Subscription[Any], ...] = ()
        self._keeps = qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        # Kept for late joiners, each with the time (ns) of its sending.
        self._kept: deque[tuple[int, Any]] = deque(maxlen=qos_profile._queue_size)
        self._make_kept: Callable[[], Any] | None = None
        self._has_published = False
        self._lifespan = qos_profile.lifespan.nanoseconds  # 0 means for ever.

    def publish(self, msg: MsgT | bytes) -> None:
        """Send a copy of a message to every matching subscription.

        With the durability TRANSIENT_LOCAL a copy is also kept for late joiners.
        """
        if isinstance(msg, bytes):
            msg = deserialize_message(msg, self.msg_type)
        if not isinstance(msg, self.msg_type):
            raise TypeError(f"Expected {self.msg_type}, got {type(msg)}")
        self._use()
        message: Any = msg
        self._sent += 1
        if self._keeps:
            with self._node._graph.lock:  # So that a late joiner gets each message once.
                now = monotonic_ns()
                self._drop_expired(now)
                self._kept.append((now, message.__received__()))
                matched = self._matched
        else:
            matched = self._matched
        for subscription in matched:
            subscription._receive(message, self)

    def _drop_expired(self, now: int) -> None:
        while self._lifespan and self._kept and now - self._kept[0][0] > self._lifespan:
            self._kept.popleft()

    def _set_latched(self, make: Callable[[], Any]) -> None:
        """Set the function that makes the one message for late joiners; none is kept any more."""
        self._make_kept = make
        self._keeps = False

    def _publish_lazily(self, make: Callable[[], Any], news: Any) -> None:
        """Send the message that `make()` returns, made only if a subscription needs it."""
        self._use()
        self._has_published = True
        message: Any = None
        for subscription in self._matched:
            if subscription._follows_changes:
                subscription._deliver(news)
                continue
            message = message or make()
            subscription._receive(message, self)

    def assert_liveliness(self) -> None:
        """Do nothing: this engine has no liveliness events."""
        self._use()

    def wait_for_all_acked(self, timeout: Duration | None = None) -> bool:
        """Return True at once: in one process every message has arrived."""
        self._use()
        return True

    def get_subscription_count(self) -> int:
        """Return how many subscriptions match in type and QoS."""
        self._use()
        return len(self._matched)

    def destroy(self) -> None:
        super().destroy()
        self._node._graph.remove_publisher(self)

    def _replay(self, subscription: Subscription[Any]) -> None:
        """Hand the kept messages to a late joiner whose durability is TRANSIENT_LOCAL.

        Kept messages older than the lifespan are dropped instead.
        """
        if subscription.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL:
            if self._make_kept is not None and self._has_published:
                subscription._receive(self._make_kept(), self)
            self._drop_expired(monotonic_ns())
            for _, message in self._kept:
                subscription._receive(message, self)
