"""The package `rclpy.lifecycle`: nodes that a manager configures, activates and so on."""

from rclpy.lifecycle.node import LifecycleNode as LifecycleNode
from rclpy.lifecycle.node import LifecycleNodeMixin as LifecycleNodeMixin
from rclpy.lifecycle.node import LifecyclePublisher as LifecyclePublisher
from rclpy.lifecycle.node import LifecycleState as LifecycleState
from rclpy.lifecycle.node import TransitionCallbackReturn as TransitionCallbackReturn

Node, NodeMixin = LifecycleNode, LifecycleNodeMixin  # The short names, which rclpy has as well.
Publisher, State = LifecyclePublisher, LifecycleState
