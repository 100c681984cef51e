"""The module `rclpy.topic_or_service_is_hidden`: names that tools leave out."""

from __future__ import annotations

HIDDEN_TOPIC_PREFIX = "_"


def topic_or_service_is_hidden(name: str) -> bool:
    """Return True if a part of the name, between slashes, begins with `_`."""
    return any(part.startswith(HIDDEN_TOPIC_PREFIX) for part in name.split("/"))
