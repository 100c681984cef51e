"""The package `rclpy.lifecycle`: nodes that a manager configures, activates and so on."""

from rclpy.lifecycle.node import (
    LifecycleNode,
    LifecycleNodeMixin,
    LifecyclePublisher,
    LifecycleState,
    TransitionCallbackReturn,
)

Node, NodeMixin = LifecycleNode, LifecycleNodeMixin  # The short names, which rclpy has as well.
Publisher, State = LifecyclePublisher, LifecycleState

__all__ = [
    "LifecycleNode",
    "LifecycleNodeMixin",
    "LifecyclePublisher",
    "LifecycleState",
    "Node",
    "NodeMixin",
    "Publisher",
    "State",
    "TransitionCallbackReturn",
]
