"""The release of ROS 2 in this process."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

EMBEDDED_RELEASE = "kilted"  # Whose rclpy the embedded engine is a part of.


def distribution() -> str:
    """Return the name of the ROS 2 release, such as `jazzy`, or "" if it is not known."""
    sourced = os.environ.get("ROS_DISTRO")
    if sourced:
        return sourced
    # By the name of its folder, since importlib.metadata imports 25 modules.
    spec = importlib.util.find_spec("rclpy")
    installed = Path((spec and spec.origin) or "").parent.parent
    for found in installed.glob("ros_*_rclpy-*.dist-info"):
        return found.name.split("_")[1]
    return ""
