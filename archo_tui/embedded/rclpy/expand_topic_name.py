"""The module `rclpy.expand_topic_name`."""

from __future__ import annotations

from rclpy._names import expand, namespace_problem, node_name_problem, topic_problem


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the fully qualified form of a topic's name as a node uses it, without remapping."""
    for what, name, problem in (
        ("topic name", topic_name, topic_problem(topic_name)),
        ("node name", node_name, node_name_problem(node_name)),
        ("node namespace", node_namespace, namespace_problem(node_namespace)),
    ):
        if problem:
            raise ValueError(f"{what} '{name}' is invalid: {problem[0]}")
    return expand(topic_name, node_name, node_namespace)
