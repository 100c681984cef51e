"""The module `rclpy.validate_node_name`: a check of node names."""

from __future__ import annotations

from rclpy import _names


def validate_node_name(node_name: str) -> bool:
    """Return True for a valid node name, else raise InvalidNodeNameException."""
    _names.validate_node_name(node_name)
    return True
