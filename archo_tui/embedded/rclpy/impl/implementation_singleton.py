"""`rclpy_implementation`: the errors of rclpy's C layer, under the name that programs know."""

from __future__ import annotations

from rclpy import _rclpy_pybind11 as rclpy_implementation

__all__ = ["rclpy_implementation"]
