"""A topic whose rate the robot file expects: measured, shown, and an alarm when it differs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node
from std_msgs.msg import String

from tests.support.console import console
from tests.support.robot import making

FILE = """
version: 1
name: robot
topics:
  - {topic: scan, rate: 10}
"""


class Lidar(Node):
    """Publishes at 10 Hz, until its rate is set."""

    def __init__(self, **options: Any) -> None:
        super().__init__("lidar", **options)
        self.publisher = self.create_publisher(String, "scan", 10)
        self.timer = self.create_timer(0.1, self.publish)

    def publish(self) -> None:
        self.publisher.publish(String(data="x"))

    def set_period(self, seconds: float) -> None:
        self.timer.timer_period_ns = int(seconds * 1e9)


@pytest.mark.waits
async def test_a_topic_that_slows_down_and_ends_is_an_alarm_with_its_numbers(
    tmp_path: Path,
) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(FILE)
    made: list[Lidar] = []
    async with console(robot=file, node_makers=[making(made, Lidar)], wait=False) as op:
        await op.press("8")
        await op.until("10.0 of 10 Hz")
        made[0].set_period(0.2)
        await op.until("/scan IS TOO SLOW, 5")
        made[0].timer.cancel()
        await op.until("/scan IS SILENT for")
        made[0].set_period(0.1)
        made[0].timer.reset()
        await op.until("10.0 of 10 Hz")
