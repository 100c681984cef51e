"""The inspection of one topic: how often its messages come, how large they are, and the last one.

Messages are counted as bytes, and decoded only when they are asked for: many of them, or large
ones, cost the ROS thread little, and the black box gets none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message

from archo_tui.clock import Clock
from archo_tui.errors import ArchoError, in_one_line
from archo_tui.robot.endpoints import fitting_qos
from archo_tui.robot.listener import Listener
from archo_tui.robot.message_rate import RATE_INTERVALS

# Seconds after a subscription in which a latched topic's messages are those that were kept for it.
_KEPT = 0.5
MAX_BYTES = 8_000_000  # Of a message that is decoded; with many small parts it takes seconds.


class Inspection:
    """A count of the messages of one topic, which lasts from `subscribe` to `unsubscribe`.

    Its attributes may be read on any thread.

    Attributes:
        topic: The full name of the topic.
        count: The number of messages that came, `kept` included.
        kept: The number of messages that were sent before, and came because they were kept: they
            tell nothing of the rate.
        kept_size: The bytes of these messages.
        newest: The last message: its number, counted from 1, and its bytes; (0, b"") before the
            first.
        size: The bytes of all messages that came.
        first: When the first message came that was not kept, in monotonic seconds; 0 before it.
        last: When the last message came, in monotonic seconds; 0 before the first.
        least: The shortest time between two messages, in seconds; None before the second.
        greatest: The longest time between two messages, in seconds; None before the second.
    """

    def __init__(
        self,
        node: Listener,
        clock: Clock,
        topic: str,
        message_class: Any,
        on_data: Callable[[float, bytes, bool], None] = lambda *_: None,
    ) -> None:
        """Create the inspection; `subscribe` starts it.

        Args:
            node: The console's node.
            clock: The clock of the times.
            topic: The full name of the topic.
            message_class: The class of its messages.
            on_data: Called on the ROS thread with the monotonic time and the bytes of each message,
                and True if it was sent before.
        """
        self._on_data = on_data
        self._node, self._clock, self._class = node, clock, message_class
        self._subscription: Any = None
        self._is_tap = False  # True while the messages are those of another subscription.
        self._qos: QoSProfile | None = None
        self.newest: tuple[int, bytes] = (0, b"")
        self.topic = topic
        self.count = self.size = self.kept = self.kept_size = 0
        self._kept_until = -math.inf
        self.first = self.last = 0.0
        self.least: float | None = None
        self.greatest: float | None = None

    def subscribe(self) -> None:
        """Begin to count, with a QoS that fits the present publishers. ROS thread only.

        If the node listens to the topic already, no second subscription is made: its messages are
        counted, the last one that it received at once.
        """
        self._is_tap = self._node.listens(self._class, self.topic)
        if self._is_tap:
            last = self._node.tap(self._class, self.topic, self._take)
            if last is not None and not self.count:
                self._take(last, was_kept=True)
            return
        self._qos = fitting_qos(self._node.get_publishers_info_by_topic(self.topic))
        if self._qos.durability == DurabilityPolicy.TRANSIENT_LOCAL:
            self._kept_until = self._clock.monotonic() + _KEPT
        self._subscription = self._node.listen_raw(self._class, self.topic, self._take, self._qos)

    def resubscribe_if_needed(self) -> None:
        """Subscribe again if the publishers, or the node's other subscription, have changed.

        Nothing is done while the QoS still fits, or without publishers. The counts go on. ROS
        thread only.
        """
        if self._node.listens(self._class, self.topic) != self._is_tap:
            self.unsubscribe()
            self.subscribe()
            return
        publishers = self._node.get_publishers_info_by_topic(self.topic)
        if self._subscription is None or not publishers or fitting_qos(publishers) == self._qos:
            return
        self.unsubscribe()
        self.subscribe()

    def unsubscribe(self) -> None:
        """End the subscription, if there is one; the counts stay. ROS thread only."""
        self._node.untap(self._take)
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _take(self, data: bytes, *, was_kept: bool = False) -> None:
        now = self._clock.monotonic()
        was_kept = was_kept or now < self._kept_until
        if was_kept:
            self.kept, self.kept_size = self.kept + 1, self.kept_size + len(data)
        elif self.count == self.kept:
            self.first = self.last = now
        else:
            interval = now - self.last
            self.least = interval if self.least is None else min(self.least, interval)
            self.greatest = interval if self.greatest is None else max(self.greatest, interval)
            self.last = now
        self.size += len(data)
        self.newest = self.count + 1, data
        self.count += 1  # Last: another thread that reads it finds the rest set.
        self._on_data(now, data, was_kept)

    @property
    def rate(self) -> float | None:
        """The mean rate in Hz from the first message to the last; None before three intervals."""
        span, intervals = self.last - self.first, self.count - self.kept - 1
        return intervals / span if span > 0 and intervals >= RATE_INTERVALS else None

    def decode(self, data: bytes) -> Any:
        """Return the message in serialized bytes, secret values masked.

        A large message takes long: call this on a thread of its own.

        Args:
            data: The bytes of the message.

        Raises:
            ArchoError: The message is larger than MAX_BYTES, or not of this topic's class.
        """
        if len(data) > MAX_BYTES:
            raise ArchoError(too_large(len(data)))
        try:
            return self._node.without_secrets(deserialize_message(data, self._class))
        except Exception as error:  # rclpy raises several types for bytes of another definition.
            why = f"not readable, its publisher may have another definition: {in_one_line(error)}"
            raise ArchoError(why) from None


def too_large(size: int) -> str:
    """Return the line that says why a message of so many bytes is not shown."""
    return f"not shown: a message of {size / 1e6:.1f} MB, more than {MAX_BYTES / 1e6:g} MB"
