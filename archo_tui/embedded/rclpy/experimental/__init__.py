"""What only the newest rclpy has: its absence says more than `cannot import`."""

from __future__ import annotations


def __getattr__(name: str) -> object:
    if name.startswith("__"):
        raise AttributeError(name)
    raise ImportError(
        f"the embedded engine is rclpy 9 (ROS 2 Kilted): it has no experimental {name}"
    )
