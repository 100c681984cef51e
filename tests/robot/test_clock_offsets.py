"""Clocks that differ: which stamps count, and when the alarm is over."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from archo_tui.robot.telemetry import ClockOffsets
from tests.support.alarms import conditions
from tests.support.clock import NOW
from tests.support.quiet import until
from tests.support.robot import making, robot
from tests.support.states import NORMAL


def stamp(seconds: float) -> Any:
    return SimpleNamespace(sec=int(seconds), nanosec=int(seconds % 1 * 1e9))


def test_three_stamps_that_are_off_are_a_large_offset() -> None:
    offsets = ClockOffsets()
    assert not offsets.add("/base", stamp(97.0), 100.0)
    assert not offsets.add("/base", stamp(97.0), 100.0)
    assert offsets.add("/base", stamp(97.0), 100.0)
    assert offsets.large == {"/base": -3.0}
    assert not offsets.add("/base", stamp(97.1), 100.0)


def test_a_late_message_is_no_offset() -> None:
    offsets = ClockOffsets()
    for late in (0.0, 5.0, 9.0, 0.2, 7.0):
        offsets.add("/base", stamp(100.0), 100.0 + late)
    assert offsets.large == {}


def test_no_stamp_is_no_offset() -> None:
    offsets = ClockOffsets()
    for _ in range(5):
        offsets.add("/odom", stamp(0.0), 100.0)
    assert offsets.large == {}


def test_a_clock_that_was_set_is_over() -> None:
    offsets = ClockOffsets()
    for _ in range(3):
        offsets.add("/base", stamp(200.0), 100.0)
    assert offsets.add("/base", stamp(100.0), 100.0)
    assert offsets.large == {}


def test_the_alarm_names_who_is_off_and_how_far() -> None:
    clocks = NORMAL._replace(clock_offsets={"/base": -3.2, "/odom": 61.0})
    text = "CLOCKS DIFFER: /odom is 61.0 s ahead, /base is 3.2 s behind: set one of them"
    assert conditions(clocks, NOW)["clocks differ"].startswith(text)


class Odometer(Node):
    """Publishes with a stamp of 1970."""

    def __init__(self, **options: Any) -> None:
        from nav_msgs.msg import Odometry

        super().__init__("odometer", **options)
        self.publisher = self.create_publisher(Odometry, "odom", 10)
        message = Odometry()
        message.header.stamp.sec = 5
        self.create_timer(0.1, lambda: self.publisher.publish(message))

    def leave(self) -> None:
        for timer in self.timers:
            timer.cancel()
        self.destroy_publisher(self.publisher)

    def simulate(self) -> None:
        self.create_publisher(Clock, "/clock", 10)


@pytest.mark.parametrize("ends", [Odometer.leave, Odometer.simulate])
async def test_what_left_or_is_simulated_has_no_clock(here: Path, ends: Any) -> None:
    pytest.importorskip("nav_msgs")
    file = here / "base.yaml"
    file.write_text(
        "version: 1\nname: Base\nstop: none\nmotion: {topic: odom, types: "
        "{nav_msgs/msg/Odometry: {speed: twist.twist.linear.x}}}\n"
    )
    made: list[Any] = []
    async with robot(making(made, Odometer), robot=file) as it:
        it.own_nodes = tuple  # As if the node ran on another computer.
        await until(lambda: "/odom" in it.snapshot.clock_offsets)
        ends(made[0])
        await until(lambda: "/odom" not in it.snapshot.clock_offsets)
