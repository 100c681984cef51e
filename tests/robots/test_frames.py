"""Transforms: listed by a line and in a dialog, and an alarm when a frame is not alive."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("tf2_msgs")

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from tests.support.console import console_with
from tests.support.plain import plain
from tests.support.shells import served, typed

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Base(Node):
    """Publishes base_link in odom at 10 Hz, and once laser in base_link."""

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        self._moving = self.create_publisher(TFMessage, "tf", 10)
        self._static = self.create_publisher(TFMessage, "tf_static", LATCHED)
        self._static.publish(self.message("base_link", "laser"))
        self.timer = self.create_timer(0.1, self.publish)

    def publish(self) -> None:
        self._moving.publish(self.message("odom", "base_link"))

    def message(self, parent: str, child: str) -> Any:
        found = TransformStamped(child_frame_id=child)
        found.header.frame_id = parent
        found.header.stamp = self.get_clock().now().to_msg()
        return TFMessage(transforms=[found])


class Dock(Node):
    """Publishes a part of the tree that nothing joins to the rest."""

    def __init__(self, **options: Any) -> None:
        super().__init__("dock", **options)
        self._static = self.create_publisher(TFMessage, "/tf_static", LATCHED)
        self._static.publish(Base.message(self, "map", "dock"))  # type: ignore[arg-type]


class Simulated(Base):
    """Its time is simulated: it publishes it, and stamps by it."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._time = self.create_publisher(Clock, "/clock", 10)

    def message(self, parent: str, child: str) -> Any:
        found = super().message(parent, child)
        found.transforms[0].header.stamp = Time(sec=7)
        return found


async def test_in_simulated_time_a_transform_is_as_old_as_its_receipt() -> None:
    code, said = await plain("tf\n", Simulated)
    assert code == 0, said
    assert re.search(r"^base_link in odom: \d+\.\d Hz, 0\.\d s old, from base$", said, re.MULTILINE)


async def test_a_robot_in_a_namespace_has_its_own_tree_or_the_common_one() -> None:
    code, said = await plain("tf\n", Base, Dock, namespace="/tb1")
    assert code == 0, said
    assert "base_link in odom: " in said
    assert "dock" not in said
    code, said = await plain("tf\n", Dock, namespace="/tb1")
    assert code == 0, said
    assert "dock in map: static, from tb1/dock\n" in said


async def test_the_transforms_are_listed_with_what_is_wrong() -> None:
    code, said = await plain("tf\n", Base, Dock)
    assert code == 0, said
    assert "listening for 2 s\n" in said
    parts = "▲ the tree is in 2 parts, no transform joins them: base_link, laser, odom; dock, map"
    assert parts in said
    assert "base_link in odom: " in said
    assert " s old, from base\n" in said
    assert "dock in map: static, from one of base, dock\n" in said
    assert "laser in base_link: static, from one of base, dock\n" in said


async def test_without_transforms_or_their_type_that_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    code, said = await plain("tf\n")
    assert code == 0, said
    assert "no transform: nobody publishes /tf or /tf_static\n" in said
    monkeypatch.setattr("archo_tui.robot.topics.frames.load_class", lambda _: None)
    code, said = await plain("tf\n", Base)
    assert code == 0, said
    assert "▲ /tf_static is tf2_msgs/msg/TFMessage, which is not installed here: " in said
    assert "install its package tf2_msgs, and restart\n" in said


@pytest.mark.real_time
async def test_a_program_gets_the_frames_as_data() -> None:
    async with served(Base) as person:
        data = json.loads((await typed("tf", "--json")).out)["data"]
        await person.end()
    assert data["faults"] == []
    frames = {frame["frame"]: frame for frame in data["frames"]}
    assert frames["base_link"]["parents"] == ["odom"]
    assert frames["base_link"]["publishers"] == ["base"]
    assert frames["laser"]["static"] is True


@pytest.mark.waits
async def test_the_dialog_shows_them_as_they_come_and_listens_only_while_it_is_open() -> None:
    async with console_with(Base) as (op, node):
        frames = op.app.station.robot.frames
        await op.press("ctrl+p")
        await op.type("transforms")
        await op.press("enter")
        await op.until("base_link in odom: 10.0 Hz")
        await op.until("laser in base_link: static, from base")
        node.timer.cancel()
        await op.until("base_link in odom: SILENT for")
        await op.press("escape")
        await op.until(lambda: not frames.transforms.frames)


async def test_a_frame_of_the_robot_file_that_is_not_alive_is_an_alarm(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text("version: 1\nname: robot\nframes:\n  - {frame: base_link, age: 1.0}\n")
    async with console_with(Base, robot=file) as (op, node):
        await op.until(lambda: "base_link" in op.app.view.snapshot.transforms.frames)
        node.timer.cancel()
        await op.until("FRAME base_link IS SILENT for")
        node.timer.reset()
        await op.until("was: FRAME base_link IS SILENT for")
