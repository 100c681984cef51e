"""The module `rclpy.validate_topic_name`: a check of topic names as written."""

from __future__ import annotations

from rclpy import _names


def validate_topic_name(name: str, *, is_service: bool = False) -> bool:
    """Return True for a valid topic or service name as a program writes it (`x`, `~/x`, `/x`)."""
    _names.validate_topic_name(name, is_service=is_service)
    return True
