"""Descriptors for the parameters of the nodes: what a console shows and rclpy checks."""

from __future__ import annotations

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor


def double(description: str, low: float, high: float) -> ParameterDescriptor:
    """A double in low .. high."""
    allowed = FloatingPointRange(from_value=low, to_value=high, step=0.0)
    return ParameterDescriptor(description=description, floating_point_range=[allowed])


def integer(description: str, low: int, high: int) -> ParameterDescriptor:
    """An integer in low .. high."""
    allowed = IntegerRange(from_value=low, to_value=high, step=1)
    return ParameterDescriptor(description=description, integer_range=[allowed])


def fixed(description: str) -> ParameterDescriptor:
    """A value that can only be given at the start."""
    return ParameterDescriptor(description=description, read_only=True)
