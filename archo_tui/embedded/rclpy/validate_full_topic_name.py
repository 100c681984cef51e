"""The module `rclpy.validate_full_topic_name`: a check of names on the graph."""

from __future__ import annotations

from rclpy import _names


def validate_full_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True for a valid topic or service name on the graph, expanded."""
    _names.validate_full_topic_name(name, is_service=is_service)
    return True
