"""The defaults and descriptors of the nodes' parameters, which consoles show and rclpy checks.

A descriptor has no field for the default, so its description says it.
"""

from __future__ import annotations

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor


def double(
    default: float, description: str, low: float, high: float
) -> tuple[float, ParameterDescriptor]:
    """Return the default and the descriptor of a double in low .. high."""
    allowed = FloatingPointRange(from_value=low, to_value=high, step=0.0)
    described = f"{description}; default {default}"
    return default, ParameterDescriptor(description=described, floating_point_range=[allowed])


def integer(default: int, description: str, low: int, high: int) -> tuple[int, ParameterDescriptor]:
    """Return the default and the descriptor of an integer in low .. high."""
    allowed = IntegerRange(from_value=low, to_value=high, step=1)
    described = f"{description}; default {default}"
    return default, ParameterDescriptor(description=described, integer_range=[allowed])


def fixed(default: int, description: str) -> tuple[int, ParameterDescriptor]:
    """Return the default and the descriptor of an integer that can only be given at the start."""
    described = f"{description}; default {default}"
    return default, ParameterDescriptor(description=described, read_only=True)
