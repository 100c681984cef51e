"""However much happens, a few snapshots a second go up."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from archo_interfaces.msg import BatteryStatus, MotorStatus
from rclpy.node import Node

from archo_tui.robot.runtime import PERIOD as SENT
from tests.support import chosen
from tests.support.clock import seconds
from tests.support.quiet import until
from tests.support.robot import making, robot

pytestmark = pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="in real time a snapshot comes as late as the machine is"
)
PERIOD = 0.02  # s between two messages


class Telling(Node):
    """A voltage that goes on, and all else as it is set; an INFO line each time."""

    def __init__(self, **options: Any) -> None:
        super().__init__("telling", **options)
        self.battery = BatteryStatus(percentage=80.0, voltage=24.0, battery_health="good")
        self.motor = MotorStatus()
        self._batteries = self.create_publisher(BatteryStatus, "battery_level", 10)
        self._motors = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(PERIOD, self.tell)

    def tell(self) -> None:
        self.battery.voltage += 0.001
        self._batteries.publish(self.battery)
        self._motors.publish(self.motor)
        self.get_logger().info(f"{self.battery.voltage} V")


@pytest.fixture
def told() -> list[Telling]:
    return []


@pytest.fixture
def telling(told: list[Telling]) -> Callable[..., Node]:
    return making(told, Telling)


async def at(when: float) -> None:
    await until(lambda: seconds() >= when)


async def test_numbers_and_lines_that_go_on_are_seen_four_times_a_second(
    telling: Callable[..., Node],
) -> None:
    async with robot(telling) as it:
        await at(seconds() + 5.0)
        times: list[float] = []
        it.subscribe(lambda _: times.append(seconds()))
        await at(seconds() + 8.0)
    gaps = [after - before for before, after in pairwise(times)]
    assert max(gaps) <= SENT + 2 * PERIOD
    assert len(times) <= 8.0 / SENT + 1
