"""Subscriptions without rclpy's event handlers: each costs a look at every message of any topic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile


def subscribe(
    node: Node, kind: Any, topic: str, callback: Callable[[Any], None], qos: QoSProfile | int
) -> Any:
    """For topics whose QoS always fits: rclpy's handlers would only log where it does not."""
    quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
    return node.create_subscription(kind, topic, callback, qos, event_callbacks=quiet)
