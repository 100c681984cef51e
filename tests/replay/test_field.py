"""A replay of a robot in the field: its pose, its parts, and topics that were only recorded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("diagnostic_msgs")
pytest.importorskip("sensor_msgs")
pytest.importorskip("nav_msgs")

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from std_msgs.msg import String

from archo_tui.recordings.replay.bag import BagFile
from tests.replay.recorded import replay, written
from tests.robots.field import Base
from tests.support import clock
from tests.support.console import console

FILE = Path(__file__).parents[1] / "robots" / "field.yaml"


class Raw(Node):
    """It publishes what the robot file only records."""

    def __init__(self, **options: Any) -> None:
        super().__init__("raw", **options)
        self._raw = self.create_publisher(String, "odom_raw", 10)
        self.create_timer(0.2, lambda: self._raw.publish(String(data="as it came")))


@pytest.mark.waits
async def test_pose_parts_and_recorded_topics_are_in_the_recording() -> None:
    made: list[Base] = []

    def base(**given: Any) -> Base:
        made.append(Base(**given))
        return made[-1]

    async with console(robot=FILE, node_makers=[base, Raw], wait=False) as op:
        await op.until("x 1.2  y 0.4  90°  map")
        made[0].parts["base: left motor"] = (DiagnosticStatus.ERROR, "too hot")
        await op.until("ERROR base: left motor (sn 12): too hot")
        for _ in range(3):  # A wait has its deadline where time is real.
            await op.at(clock.seconds() + 22.0)
        # The pose was sent once, long before.
        await op.press("ctrl+x")
        await op.until("STOPPED")
        path = await written(op)
    bag = BagFile(path)
    async with replay(path) as watcher:
        watcher.app.before_suspend()  # As ctrl+z has it called.
        await watcher.show(watcher.player.end)
        assert "x 1.2  y 0.4  90°  map" in watcher.text
        assert "base: left motor" in watcher.text
        raw = list(bag.messages(watcher.player.start, watcher.player.end, {"/odom_raw"}))
        assert raw
