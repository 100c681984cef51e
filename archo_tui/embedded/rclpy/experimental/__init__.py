"""What rclpy tries out."""

from __future__ import annotations

from rclpy.experimental.events_executor import EventsExecutor

__all__ = ["EventsExecutor"]


def __getattr__(name: str) -> object:
    """What only the newest rclpy has: its absence says more than `cannot import`."""
    if name.startswith("__"):
        raise AttributeError(name)
    raise ImportError(
        f"the embedded engine is rclpy 9 (ROS 2 Kilted): it has no experimental {name}"
    )
