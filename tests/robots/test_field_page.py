"""docs/field.md, as written: what the files say, and what the lines do to three robots."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("irobot_create_msgs")
pytest.importorskip("nav2_msgs")

from geometry_msgs.msg import PoseWithCovarianceStamped
from irobot_create_msgs.action import Dock, DriveDistance, RotateAngle, Undock
from irobot_create_msgs.srv import EStop
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import Odometry
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import BatteryState

from archo_tui.robot_file.load import load
from archo_tui.verbs import topics
from tests.robots.cart import Cart
from tests.support.console import console_with
from tests.support.plain import operated
from tests.support.quiet import until
from tests.support.stand_in import Drive


class Navigator(LifecycleNode):
    """Nav2's bt_navigator: it takes goals while it is active."""

    def __init__(self, **options: Any) -> None:
        super().__init__("bt_navigator", **options)
        self._is_active = False
        name, left = "navigate_to_pose", "distance_remaining"
        Drive(self, NavigateToPose, name, left, accepts=lambda _: self._is_active)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._is_active = True
        return super().on_activate(state)


class Localization(Node):
    """Nav2's amcl: the pose in the map, sent once and kept."""

    def __init__(self, **options: Any) -> None:
        super().__init__("amcl", **options)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._pose = self.create_publisher(PoseWithCovarianceStamped, "amcl_pose", latched)
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x = 1.2
        message.pose.pose.orientation.w = 1.0
        self._pose.publish(message)


class Base(Node):
    """Any base with odometry."""

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        self._odometry = self.create_publisher(Odometry, "odom", 10)
        self.create_timer(0.1, lambda: self._odometry.publish(Odometry()))


class Create3(Base):
    """A Create 3: battery, docking, two moves, and an emergency stop."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._battery = self.create_publisher(BatteryState, "battery_state", 10)
        self.create_timer(0.5, self._publish_battery)
        self.create_service(EStop, "e_stop", self._on_stop)
        self._drives = [
            Drive(self, Dock, "dock"),
            Drive(self, Undock, "undock"),
            Drive(self, DriveDistance, "drive_distance", "remaining_travel_distance"),
            Drive(self, RotateAngle, "rotate_angle", "remaining_angle_travel"),
        ]

    def _publish_battery(self) -> None:
        self._battery.publish(BatteryState(percentage=0.8, voltage=15.6))

    def _on_stop(self, request: Any, response: Any) -> Any:
        for drive in self._drives if request.e_stop_on else ():
            drive.end("abort")
        response.success = True
        return response


NAV2 = (Navigator, Localization, Base)
TURTLEBOT4 = (Navigator, Localization, Create3)
CREATE3 = (Create3,)


PAGE = (Path(__file__).parents[2] / "docs" / "field.md").read_text(encoding="utf-8")
SECTIONS = {
    "nav2": "## A robot with Nav2",
    "turtlebot4": "## A TurtleBot 4",
    "create3": "## A Create",
}
ROBOTS: dict[str, tuple[Any, ...]] = {
    "nav2": NAV2,
    "turtlebot4": TURTLEBOT4,
    "create3": CREATE3,
}
# what each robot's lines are answered with, in this order
ANSWERS = {
    "nav2": (
        "bt_navigator is unconfigured",
        "bt_navigator is inactive",
        "bt_navigator is active",
        "go to pose x 2.0, y 1.0, yaw 90.0: accepted",
        "x 1.2, y 0.0, 0°, map",
        "goal CANCELLED",
        "robot has no STOP: use the hardware stop (this is not a STOP",
    ),
    "turtlebot4": ("undock: accepted", "STOP: ", "release stop: "),
    "create3": ("drive distance distance 0.5, ", "STOP: ", "release stop: "),
}


def blocks(robot: str, language: str) -> list[str]:
    """The blocks of a language in the section of a robot."""
    section = PAGE[PAGE.index(SECTIONS[robot]) :]
    section = section[: section.index("\n## ")]
    return re.findall(rf"^```{language}\n(.*?)^```$", section, re.MULTILINE | re.DOTALL)


def with_stop(text: str) -> str:
    """The file with its proposed STOP uncommented, as the page says."""
    lines = text.splitlines()
    if "# stop:" in lines:
        at = lines.index("# stop:")
        lines[at : at + 5] = [line.removeprefix("# ") for line in lines[at : at + 5]]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("robot", ROBOTS)
async def test_each_robot_is_described_driven_and_stopped(
    robot: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(topics, "LISTENING", 1.5)
    file = tmp_path / "mine.yaml"
    async with operated(*ROBOTS[robot]) as person:
        station = person._plain._station
        await until(lambda: len(station.robot.snapshot.nodes) == len(ROBOTS[robot]))
        await until(lambda: station.robot.snapshot.actions)
        text = asyncio.ensure_future(topics.robot_file_text(station))
        await until(text.done)
        file.write_text(with_stop(text.result()))
        for shown in blocks(robot, "yaml"):
            assert shown in text.result()
    assert (load(file).stop is None) == (robot == "nav2")
    async with operated(*ROBOTS[robot], robot=file) as person:
        await until(lambda: len(person._plain._station.robot.snapshot.actions) > 0)
        lines = "".join(blocks(robot, robot)).splitlines()
        assert lines
        for line, answer in zip(lines, ANSWERS[robot], strict=True):
            person.type(f"{line}\n")
            await person.until(answer)


@pytest.mark.waits
async def test_the_palette_writes_a_file_that_shows_the_robots_data(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(topics, "LISTENING", 0.3)
    cart = Path(__file__).with_name("cart.yaml")
    async with console_with(Cart, "blink", robot=cart) as (op, _):
        await op.press("ctrl+p")
        await op.type("Describe this robot")
        await op.press("enter")
        await op.until("listens for")
        await op.press("enter")
        await op.until("Saved to robot.yaml.")
    path = here / "robot.yaml"
    made = load(path)
    assert made.battery is not None
    assert made.battery.topic == "battery_level"
    assert [goal.action for goal in made.goals] == ["move_to_shelf"]
    assert [command.service for command in made.commands] == ["blink"]
    assert made.stop is None
    assert "# stop: {service: emergency_stop}" in path.read_text()
    async with console_with(Cart, "blink", robot=path) as (op, _):
        await op.until("Go to shelf")
