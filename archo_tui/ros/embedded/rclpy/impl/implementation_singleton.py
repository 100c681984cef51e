"""The name `rclpy_implementation`, by which programs know the errors of rclpy's C layer."""

from __future__ import annotations

from rclpy import _rclpy_pybind11 as rclpy_implementation

__all__ = ["rclpy_implementation"]
