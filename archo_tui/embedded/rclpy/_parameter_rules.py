"""The rules of a parameter's descriptor: read-only, type, range, step."""

from __future__ import annotations

import math
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.parameter import Parameter

RELATIVE_TOLERANCE = 1e-6  # rclpy's PARAM_REL_TOL


def check(parameter: Parameter[Any], descriptor: ParameterDescriptor, *, declaring: bool) -> str:
    """Return why a descriptor forbids a parameter's value, in rclpy's words, or "".

    The ends of a range are always allowed, even if no step leads to them.
    """
    if descriptor.read_only and not declaring:
        return f"Trying to set a read-only parameter: {parameter.name}."
    if not descriptor.dynamic_typing:
        if parameter.type_ == Parameter.Type.NOT_SET:
            return "" if declaring else "Static parameter cannot be undeclared"
        if parameter.type_ != descriptor.type:
            return (
                f"Wrong parameter type, expected '{Parameter.Type(descriptor.type)}' "
                f"got '{parameter.type_}'"
            )
    if parameter.type_ == Parameter.Type.INTEGER and descriptor.integer_range:
        return _integer(parameter, descriptor.integer_range[0])
    if parameter.type_ == Parameter.Type.DOUBLE and descriptor.floating_point_range:
        return _floating_point(parameter, descriptor.floating_point_range[0])
    return ""


def _integer(parameter: Parameter[Any], allowed: Any) -> str:
    low, high = sorted((allowed.from_value, allowed.to_value))
    value = parameter.value
    if value in (low, high):
        return ""
    if not low < value < high:
        return f"Parameter {parameter.name} out of range. Min: {low}, Max: {high}, value: {value}"
    if allowed.step and (value - low) % allowed.step:
        return (
            f"The parameter value for {parameter.name} is not a valid step. "
            f"Min: {low}, max: {high}, value: {value}, step: {allowed.step}"
        )
    return ""


def _floating_point(parameter: Parameter[Any], allowed: Any) -> str:
    low, high = sorted((allowed.from_value, allowed.to_value))
    value = parameter.value
    if _close(value, low) or _close(value, high):
        return ""
    if not low < value < high:
        return f"Parameter {parameter.name} out of range Min: {low}, Max: {high}, value: {value}"
    if allowed.step:
        steps = round((value - low) / allowed.step)
        if not _close(low + steps * allowed.step, value):
            return (
                f"The parameter value for {parameter.name} is not close enough to a valid step. "
                f"Min: {low}, max: {high}, value: {value}, step: {allowed.step}"
            )
    return ""


def _close(left: float, right: float) -> bool:
    return math.isclose(left, right, rel_tol=RELATIVE_TOLERANCE)
