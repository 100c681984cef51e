"""Topics listened to for a short time: how often each comes, and its last message."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rclpy.node import Node

from archo_tui.clock import Clock
from archo_tui.robot.endpoints import fitting_qos


class Sample:
    """The messages that came on one topic.

    Attributes:
        message: The last message; None if none came.
    """

    def __init__(self) -> None:
        """Begin with no message."""
        self.message: Any = None
        self._count = 0
        self._first = self._last = 0.0  # Monotonic s.

    def add(self, message: Any, now: float) -> None:
        """Count a message that came at `now`, in monotonic s."""
        self.message, self._last = message, now
        if not self._count:
            self._first = now
        self._count += 1

    @property
    def rate(self) -> float | None:
        """Return the messages in a second; None before the second message."""
        span = self._last - self._first
        return (self._count - 1) / span if span > 0 else None


class Sampling:
    """Subscriptions to some topics, from `begin` to `end`.

    Attributes:
        samples: What has come so far, by the full name of the topic; may be read on any thread.
    """

    def __init__(self, node: Node, clock: Clock, topics: Mapping[str, Any]) -> None:
        """Subscribe to nothing yet.

        Args:
            node: The console's node. The black box gets none of the messages.
            clock: The clock of the rates.
            topics: Message classes by the full name of the topic.
        """
        self._node, self._clock, self._topics = node, clock, topics
        self.samples = {topic: Sample() for topic in topics}
        self._subscriptions: list[Any] = []

    def begin(self) -> None:
        """Subscribe, with a QoS that fits the publishers. ROS thread only."""
        for topic, message_class in self._topics.items():
            publishers = self._node.get_publishers_info_by_topic(topic)
            subscription = self._node.create_subscription(
                message_class, topic, self._callback(self.samples[topic]), fitting_qos(publishers)
            )
            self._subscriptions.append(subscription)

    def _callback(self, sample: Sample) -> Any:
        return lambda message: sample.add(message, self._clock.monotonic())

    def end(self) -> None:
        """Unsubscribe. ROS thread only."""
        while self._subscriptions:
            self._node.destroy_subscription(self._subscriptions.pop())
