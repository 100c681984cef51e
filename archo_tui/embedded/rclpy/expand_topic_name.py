"""`rclpy.expand_topic_name`."""

from __future__ import annotations

from rclpy._names import expand, validate_namespace, validate_node_name


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """The fully qualified form of a topic's name. Raises the names' exceptions, ValueError."""
    validate_node_name(node_name)
    validate_namespace(node_namespace)
    return expand(topic_name, node_name, node_namespace)
