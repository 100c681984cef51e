"""Enter on a topic of the Graph: who publishes, who subscribes, and which side is to change."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import String

from tests.support.console import console


class Lidar(Node):
    """It publishes best effort."""

    def __init__(self, **options: Any) -> None:
        super().__init__("lidar", **options)
        self._scan = self.create_publisher(String, "scan", qos_profile_sensor_data)


class Viewer(Node):
    """It asks for reliable messages that are kept."""

    def __init__(self, **options: Any) -> None:
        super().__init__("viewer", **options)
        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(String, "scan", lambda _: None, qos)


async def test_ends_that_do_not_fit_are_named_with_the_side_to_change() -> None:
    async with console(node_makers=[Lidar, Viewer], wait=False) as op:
        await op.until(lambda: any(r.name == "/scan" for r in op.app.view.snapshot.resources))
        await op.press("8")
        while not (row := op.app.main.graph.selected) or row.resource.name != "/scan":
            await op.press("down")
        await op.press("enter")
        await op.until("does not fit")
        await op.until("std_msgs/msg/String  BEST_EFFORT, VOLATILE")
        await op.until("std_msgs/msg/String  RELIABLE, TRANSIENT_LOCAL")
        await op.until("viewer hears nothing of lidar on /scan: it asks for RELIABLE")
        await op.until("Publish RELIABLE, or subscribe with BEST_EFFORT")
        await op.press("escape")


async def test_ends_that_fit_are_said_to_fit() -> None:
    async with console() as op:
        await op.press("8")
        while not (row := op.app.main.graph.selected) or row.resource.name != "/battery_level":
            await op.press("down")
        await op.press("enter")
        await op.until("types and QoS of all of them fit")
        assert "/dashboard" in op.text
