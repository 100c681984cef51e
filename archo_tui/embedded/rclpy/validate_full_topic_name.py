"""`rclpy.validate_full_topic_name`: whether a name is one on the graph."""

from __future__ import annotations

from rclpy import _names
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException


def validate_full_topic_name(name: str, *, is_service: bool = False) -> bool:
    """True. Raises InvalidTopicNameException or InvalidServiceNameException."""
    if not name.startswith("/"):
        error = InvalidServiceNameException if is_service else InvalidTopicNameException
        raise error(name, "topic name must be absolute, it must lead with a '/'", 0)
    _names.expand(name, "node", "/", is_service=is_service)
    return True
