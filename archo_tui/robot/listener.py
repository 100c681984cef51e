"""The client's node: what it hears is heard by the black box as well."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile

Heard = Callable[[str, Any], None]  # topic, fully qualified, and message


class Listener(Node):
    """Calls `heard(topic, message)` with each message of its topics, before anybody else."""

    def __init__(
        self,
        name: str,
        heard: Heard,
        masks: Mapping[Any, Callable[[Any], Any]],
        **options: Any,
    ) -> None:
        """Make the node.

        Args:
            name: Its name.
            heard: Is called on the thread that spins the node.
            masks: By message class, what is called to get the message that `heard` is given in
                place of one that may hold secrets.
            **options: As `rclpy.node.Node` takes them.
        """
        super().__init__(name, **options)
        self._heard, self._masks = heard, masks

    def listen(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: QoSProfile | int
    ) -> Any:
        """A subscription with rclpy's event handlers, which log where the QoS does not fit."""
        return self._listen(kind, topic, callback, qos)

    def listen_quietly(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: QoSProfile | int
    ) -> Any:
        """Without them, where the QoS always fits: they cost a look at every message."""
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        return self._listen(kind, topic, callback, qos, event_callbacks=quiet)

    def _listen(
        self,
        kind: Any,
        topic: str,
        callback: Callable[[Any], None],
        qos: QoSProfile | int,
        **options: Any,
    ) -> Any:
        name, mask = self.resolve_topic_name(topic), self._masks.get(kind)

        def both(message: Any) -> None:
            self._heard(name, message if mask is None else mask(message))
            callback(message)

        return self.create_subscription(kind, topic, both, qos, **options)
