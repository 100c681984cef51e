"""A robot in the field: where it is, what it reports of its parts, and how often."""

from __future__ import annotations

from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("diagnostic_msgs")
pytest.importorskip("sensor_msgs")
pytest.importorskip("nav_msgs")

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from std_msgs.msg import String

from tests.robots.field import Base
from tests.support.console import Console, console_with
from tests.support.plain import plain

FILE = Path(__file__).with_name("field.yaml")
MOTOR = "base: left motor"


def field() -> AbstractAsyncContextManager[tuple[Console, Base]]:
    """The console, and the robot's node."""
    return console_with(Base, "/diagnostics", robot=FILE)


async def test_a_part_that_fails_is_an_alarm_and_enter_lists_all_parts() -> None:
    async with field() as (op, node):
        await op.until("75.0 %  24.5 V")
        await op.until("x 1.2  y 0.4  90°  map")
        await op.until("● IDLE")
        below = op.line("^x stop")
        assert "lamp" not in below
        assert "Lamp" in op.line("STOP  ")  # Its button.
        assert "Lamp" not in op.line("palette")
        node.parts[MOTOR] = (DiagnosticStatus.ERROR, "too hot")
        await op.until("ERROR base: left motor (sn 12): too hot")
        assert op.line("ERROR base").strip().startswith("✗ ERROR base")
        node.parts[MOTOR] = (DiagnosticStatus.OK, "fine")
        await op.until("over")
        await op.press("a")
        await op.until(lambda: "ERROR base" not in op.text)
        node.parts["base: fan"] = (DiagnosticStatus.OK, "turns")
        node.parts[MOTOR] = (DiagnosticStatus.WARN, "warm")
        await op.until("WARN base: left motor (sn 12): warm")
        await op.press("A", "enter")
        await op.until("Diagnostics")
        await op.until("▲ WARN  base: left motor (sn 12): warm")
        await op.until("● OK    base: fan (sn 12): turns")
        node.parts[MOTOR] = (DiagnosticStatus.ERROR, "hot")
        await op.until("✗ ERROR base: left motor (sn 12): hot")
        await op.press("escape")
        node.parts["motor@left"] = (DiagnosticStatus.ERROR, "burnt")
        node.parts["motor@right"] = (DiagnosticStatus.OK, "fine")
        await op.until("ERROR motor (left): burnt")
        await op.press("A", "enter")
        await op.until("✗ ERROR motor (left): burnt")
        await op.until("● OK    motor (right): fine")


@pytest.mark.waits
async def test_a_silent_part_grows_older_is_acknowledged_and_forgotten_by_keys(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in ("archo_tui.robot.state.readings", "archo_tui.verbs.show"):
        monkeypatch.setattr(f"{module}.FORGET_AFTER", 12.0)
    async with field() as (op, node):
        node.parts["motor@left"] = (DiagnosticStatus.OK, "fine")
        await op.until(lambda: len(op.app.view.snapshot.diagnostics) == 2)
        del node.parts["motor@left"]
        await op.until("STALE motor (left): no status for")
        await op.press("A", "enter", "f")
        await op.until("motor (left): only a part that has been silent for 12 s can be forgotten")
        await op.until("f forget a silent part")
        await op.press("f")
        await op.until(lambda: "? STALE motor" not in op.text)
        assert "forget a silent part" not in op.text
        await op.press("escape", "escape")
        await op.until("diagnostics: motor (left) was forgotten")
        await op.press("a")  # its alarm is over
        node.parts["base:  fan"] = (DiagnosticStatus.WARN, "slow")
        await op.until("WARN base:")
        station = op.session.station
        outcome = await op.app.verbs["ack"].run(station, {"alarm": "diagnostics base: fan"})
        assert outcome.ok
        assert station.view.alarms[0].acknowledged
        del node.parts[MOTOR]
        await op.until("STALE base: left motor (sn 12): no status for")
        await op.press("A", "enter")
        await op.until("? STALE base: left motor (sn 12): fine (old, ")
        await op.until("(old, 1")  # 10 s and more: a silent part has been shown since 5 s.


async def test_words_tell_pose_and_parts() -> None:
    _, said = await plain("status\ndiagnostics\n", robot=FILE, node_makers=[Base])
    assert "x 1.2, y 0.4, 90°, map" in said
    assert "● OK    base: left motor (sn 12): fine" in said


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
async def test_a_topic_that_slows_down_and_ends_is_an_alarm_with_its_numbers(here: Path) -> None:
    file = here / "robot.yaml"
    file.write_text("version: 1\nname: robot\ntopics:\n  - {topic: scan, rate: 10}\n")
    async with console_with(Lidar, robot=file) as (op, node):
        await op.press("8")
        await op.until("10.0 of 10 Hz")
        node.set_period(0.2)
        await op.until("/scan IS TOO SLOW, 5")
        node.timer.cancel()
        await op.until("/scan IS SILENT for")
        node.set_period(0.1)
        node.timer.reset()
        await op.until("10.0 of 10 Hz")
