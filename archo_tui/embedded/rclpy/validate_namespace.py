"""The module `rclpy.validate_namespace`: a check of namespaces."""

from __future__ import annotations

from rclpy import _names


def validate_namespace(namespace: str) -> bool:
    """Return True for a valid namespace, else raise InvalidNamespaceException."""
    _names.validate_namespace(namespace)
    return True
