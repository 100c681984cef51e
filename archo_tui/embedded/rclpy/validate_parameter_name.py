"""The module `rclpy.validate_parameter_name`: a check of parameter names."""

from __future__ import annotations

from rclpy.exceptions import InvalidParameterException


def validate_parameter_name(name: str) -> bool:
    """Return True for any name but an empty one, which raises InvalidParameterException."""
    if not name:
        raise InvalidParameterException(name)
    return True
