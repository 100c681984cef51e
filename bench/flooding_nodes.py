"""Nodes that the console of `bench/stop.py` runs: they note each STOP, and flood it.

FLOOD in the environment is what the flood consists of (`lines`, `messages`, or empty for none);
HEARD is the file that gets the monotonic time of each call of STOP.
"""

from __future__ import annotations

import os
import time
from typing import Any

from archo_bringup.motor_controller import MotorController
from archo_interfaces.msg import BatteryStatus
from rclpy.node import Node

_RATE, _BURSTS = 10_000, 100  # lines or messages, and bursts of them, a second


class Stopped(MotorController):
    """The motor's node, which notes when it is told to stop."""

    def emergency_stop(self, request: Any, response: Any) -> Any:
        with open(os.environ["HEARD"], "a") as file:
            file.write(f"{time.monotonic()}\n")
        return super().emergency_stop(request, response)


class BatteryMonitor(Node):
    """A node in place of the battery's, which publishes or logs far too much."""

    def __init__(self, **options: Any) -> None:
        super().__init__("battery_monitor", **options)
        self.number = 0
        self.publisher = self.create_publisher(BatteryStatus, "battery_level", 10)
        flood = {"lines": self.log, "messages": self.publish}.get(os.environ["FLOOD"])
        self.create_timer(1.0, self.publish)
        if flood is not None:
            self.create_timer(1 / _BURSTS, lambda: [flood() for _ in range(_RATE // _BURSTS)])

    def log(self) -> None:
        """Log a line that no other one is like."""
        self.number += 1
        letters = "".join(chr(97 + int(digit)) for digit in str(self.number))
        self.get_logger().warning(f"line {letters}")

    def publish(self) -> None:
        """Publish a reading that differs from the one before."""
        self.number += 1
        self.publisher.publish(BatteryStatus(percentage=50.0 + self.number % 40, voltage=24.0))
