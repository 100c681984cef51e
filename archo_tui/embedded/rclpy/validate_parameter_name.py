"""`rclpy.validate_parameter_name`: whether a parameter may be called so."""

from __future__ import annotations

from rclpy.exceptions import InvalidParameterException


def validate_parameter_name(name: str) -> bool:
    """True. Raises InvalidParameterException for an empty name."""
    if not name:
        raise InvalidParameterException(name)
    return True
