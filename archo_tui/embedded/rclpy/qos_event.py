"""The module `rclpy.qos_event`, the old name of `rclpy.event_handler`."""

from __future__ import annotations

from rclpy.event_handler import *  # noqa: F403
from rclpy.event_handler import __all__ as __all__
