"""`rclpy.validate_node_name`: whether a node's name is allowed."""

from __future__ import annotations

from rclpy import _names


def validate_node_name(node_name: str) -> bool:
    """True. Raises InvalidNodeNameException."""
    _names.validate_node_name(node_name)
    return True
