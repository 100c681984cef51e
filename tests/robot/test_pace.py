"""How soon news go up: words, that a person acts on, sooner than numbers that only go on."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import pytest
from archo_interfaces.msg import BatteryStatus, MotorStatus
from rclpy.node import Node

from archo_tui.robot.robot import Robot
from archo_tui.robot.snapshot_sender import FLUSH_PERIOD, STREAM_PERIOD
from archo_tui.robot.state.snapshot import Snapshot
from tests.support import chosen
from tests.support.clock import seconds
from tests.support.night import corners
from tests.support.quiet import until
from tests.support.robot import making, robot

pytestmark = pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="in real time a snapshot comes as late as the machine is"
)
PERIOD = 0.02  # s between two messages
PAUSES = (0.0, 0.05, 0.13, 0.33)  # s after a snapshot: the next one is near, or far


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


async def test_numbers_and_lines_that_go_on_are_seen_two_or_three_times_a_second(
    telling: Callable[..., Node],
) -> None:
    async with robot(telling) as it:
        await at(seconds() + 5.0)
        times: list[float] = []
        it.subscribe(lambda _: times.append(seconds()))
        await at(seconds() + 8.0)
    gaps = [after - before for before, after in pairwise(times)]
    assert max(gaps) <= STREAM_PERIOD + PERIOD
    assert len(times) < 0.8 * 8.0 / FLUSH_PERIOD


CHANGES: dict[str, tuple[Callable[[Telling, bool], None], Callable[[Snapshot], object]]] = {
    "stopped": (
        lambda node, on: setattr(node.motor, "emergency_stopped", on),
        lambda snapshot: snapshot.motion.stopped,
    ),
    "moving": (
        lambda node, on: setattr(node.motor, "moving", on),
        lambda snapshot: snapshot.motion.moving,
    ),
    "charging": (
        lambda node, on: setattr(node.battery, "is_charging", on),
        lambda snapshot: bool(snapshot.battery.charging),
    ),
    "its health": (
        lambda node, on: setattr(node.battery, "battery_health", "replace" if on else "good"),
        lambda snapshot: snapshot.battery.health == "replace",
    ),
    "not readable": (
        lambda node, on: setattr(node.battery, "percentage", 400.0 if on else 80.0),
        lambda snapshot: bool(snapshot.battery.unreadable),
    ),
}


async def soon(it: Robot, holds: Callable[[Snapshot], object]) -> None:
    """It is seen within the shorter of the two periods."""
    began = seconds()
    await until(lambda: holds(it.snapshot))
    assert seconds() - began <= FLUSH_PERIOD + 2 * PERIOD


def says(text: str, snapshot: Snapshot) -> bool:
    return any(event.text == text for event in snapshot.events)


@pytest.mark.parametrize("what", corners(["stopped"], [*CHANGES][1:]))
async def test_what_a_person_acts_on_does_not_wait_for_numbers(
    telling: Callable[..., Node], told: list[Telling], what: str
) -> None:
    change, holds = CHANGES[what]
    async with robot(telling) as it:
        await at(seconds() + 5.0)
        for pause in PAUSES:
            change(told[0], True)
            await soon(it, holds)
            await at(seconds() + pause)
            change(told[0], False)
            await soon(it, lambda snapshot: not holds(snapshot))
            await at(seconds() + pause)


async def test_a_warning_does_not_wait_for_lines_of_less_weight(
    telling: Callable[..., Node], told: list[Telling]
) -> None:
    async with robot(telling) as it:
        await at(seconds() + 5.0)
        for part, pause in zip(("belt", "brake", "wheel", "fork"), PAUSES, strict=True):
            text = f"the {part} slips"
            told[0].get_logger().warning(text)
            await soon(it, partial(says, text))
            await at(seconds() + pause)
