"""The node of the robot's client, which hands every message to the black box, too."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile

MessageCallback = Callable[[str, Any], None]  # Gets the full name of a topic, and a message.


class _Heard:
    """A subscription with decoded messages.

    Attributes:
        subscription: rclpy's object.
        last: Its last message; None before the first.
    """

    def __init__(self) -> None:
        self.subscription: Any = None
        self.last: Any = None


class Listener(Node):
    """A node that calls `on_message` with each message, before the callback of its subscription."""

    def __init__(
        self,
        name: str,
        on_message: MessageCallback,
        masks: Mapping[Any, Callable[[Any], Any]],
        **options: Any,
    ) -> None:
        """Make the node.

        Args:
            name: The name of the node.
            on_message: Called with topic and message, on the thread that spins the node.
            masks: By message class, a function that returns the message for `on_message`, without
                secrets, for a message that was received.
            **options: Passed to `rclpy.node.Node`.
        """
        super().__init__(name, **options)
        self._on_message, self._masks = on_message, masks
        self._heard: dict[tuple[str, Any], _Heard] = {}  # By full topic and message class.
        # The same; they outlast a subscription that is replaced by one with another QoS.
        self._taps: dict[tuple[str, Any], list[MessageCallback]] = {}

    def listen(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: QoSProfile | int
    ) -> Any:
        """Subscribe with rclpy's default event handlers, which log an incompatible QoS.

        Args:
            kind: The message class.
            topic: The name of the topic.
            callback: Called with each message on the thread that spins the node.
            qos: The QoS, or the depth of the history.

        Returns:
            The subscription.
        """
        return self._listen(kind, topic, callback, qos)

    def listen_quietly(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: QoSProfile | int
    ) -> Any:
        """Subscribe as `listen` does, without event handlers, which rclpy checks at each wake-up.

        Use it where the QoS always fits.
        """
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        return self._listen(kind, topic, callback, qos, event_callbacks=quiet)

    def listen_raw(
        self, kind: Any, topic: str, callback: Callable[[bytes], None], qos: QoSProfile
    ) -> Any:
        """Subscribe to messages as bytes, of which `on_message` gets none.

        Args:
            kind: The message class.
            topic: The name of the topic.
            callback: Called with each serialized message on the thread that spins the node.
            qos: A QoS that fits the publishers.

        Returns:
            The subscription.
        """
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        return self.create_subscription(kind, topic, callback, qos, event_callbacks=quiet, raw=True)

    def listens(self, kind: Any, topic: str) -> bool:
        """Return True if the node has a subscription by `listen` or `listen_quietly`.

        Args:
            kind: The message class.
            topic: The full name of the topic.
        """
        return (topic, kind) in self._heard

    def tap(self, kind: Any, topic: str, callback: MessageCallback) -> None:
        """Call a function with each message of a subscription, and at once with the last one.

        Args:
            kind: The message class.
            topic: The full name of the topic, to which the node listens.
            callback: Called with topic and message on the thread that spins the node.
        """
        self._taps.setdefault((topic, kind), []).append(callback)
        last = self._heard[topic, kind].last
        if last is not None:
            callback(topic, last)

    def untap(self, callback: MessageCallback) -> None:
        """Stop calling a function that was given to `tap`."""
        for taps in self._taps.values():
            if callback in taps:
                taps.remove(callback)

    def destroy_subscription(self, subscription: Any) -> bool:
        for key, heard in tuple(self._heard.items()):
            if heard.subscription is subscription:
                del self._heard[key]
        return super().destroy_subscription(subscription)

    def without_secrets(self, message: Any) -> Any:
        """Return a message as `on_message` would get it. Any thread."""
        mask = self._masks.get(type(message))
        return message if mask is None else mask(message)

    def _listen(
        self,
        kind: Any,
        topic: str,
        callback: Callable[[Any], None],
        qos: QoSProfile | int,
        **options: Any,
    ) -> Any:
        name, mask = self.resolve_topic_name(topic), self._masks.get(kind)

        heard = _Heard()

        def both(message: Any) -> None:
            self._on_message(name, message if mask is None else mask(message))
            callback(message)
            heard.last = message
            for tap in tuple(self._taps.get((name, kind), ())):
                tap(name, message)

        heard.subscription = self.create_subscription(kind, topic, both, qos, **options)
        self._heard[name, kind] = heard  # Only now: rclpy may have raised.
        return heard.subscription
