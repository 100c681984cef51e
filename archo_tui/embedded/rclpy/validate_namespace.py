"""`rclpy.validate_namespace`: whether a namespace is allowed."""

from __future__ import annotations

from rclpy import _names


def validate_namespace(namespace: str) -> bool:
    """True. Raises InvalidNamespaceException."""
    _names.validate_namespace(namespace)
    return True
