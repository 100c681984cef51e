"""The module `rclpy.validate_parameter_name`: a check of parameter names."""

from __future__ import annotations

from rclpy.exceptions import InvalidParameterException


def validate_parameter_name(name: str) -> bool:
    """Return True, or raise InvalidParameterException for an empty name."""
    if not name:
        raise InvalidParameterException(name)
    return True
