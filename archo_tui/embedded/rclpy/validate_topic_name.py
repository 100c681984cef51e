"""`rclpy.validate_topic_name`: whether a topic's name is allowed."""

from __future__ import annotations

from rclpy import _names


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """True. Raises InvalidTopicNameException or InvalidServiceNameException."""
    _names.validate_topic_name(name, is_service=is_service)
    return True
