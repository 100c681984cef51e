"""The module `rclpy.validate_topic_name`: a check of topic names as written."""

from __future__ import annotations

from rclpy import _names


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True for a valid topic or service name as a program writes it (`x`, `~/x`, `/x`).

    Raises:
        InvalidTopicNameException: The name is not valid.
        InvalidServiceNameException: The name is not valid, and `is_service` is True.
        TypeError: The name is not a str.
    """
    _names.validate_topic_name(name, is_service=is_service)
    return True
