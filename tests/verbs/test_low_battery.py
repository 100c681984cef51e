"""A low battery asks before a goal is sent: one rule, whoever types it and whether it charges."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from archo_bringup.motor_controller import MotorController
from archo_interfaces.msg import BatteryStatus
from rclpy.node import Node

from tests.support.console import LONG, console
from tests.support.plain import Typed, operated
from tests.support.quiet import until
from tests.support.robot import making

QUESTION = "The battery is low, 4.0 %{}. {} all the same? (add --yes to do it)\n"


class Battery(Node):
    """A battery at 4 %, which may charge."""

    def __init__(self, *, charges: bool = False, **options: Any) -> None:
        super().__init__("battery_monitor", **options)
        self.status = BatteryStatus(percentage=4.0, is_charging=charges, battery_health="warning")
        publisher = self.create_publisher(BatteryStatus, "battery_level", 10)
        self.create_timer(0.5, lambda: publisher.publish(self.status))


@asynccontextmanager
async def at_four_percent(*, charges: bool = False) -> AsyncIterator[tuple[Typed, Battery]]:
    made: list[Battery] = []
    battery = making(made, Battery, charges=charges)
    async with operated(MotorController, battery, ros_args=LONG) as person:
        robot = person.station.robot
        await until(lambda: robot.snapshot.battery.percentage is not None)
        if not charges:
            await person.until("LOW BATTERY 4.0 %")
        yield person, made[0]


async def test_no_goal_is_sent_unasked_and_a_yes_is_for_the_whole_list() -> None:
    async with at_four_percent() as (person, _):
        person.type("go 12 7\nsend_goal /move_to_shelf 12\nstatus\n")
        await person.until(f"failed: go: {QUESTION.format('', 'Send')}")
        await person.until(f"failed: send_goal: {QUESTION.format('', 'Send')}")
        assert person.station.robot.snapshot.goal is None
        await person.enter("go 12 7 --yes", "go to shelf 12: accepted")
        await person.until("queue: 7")
        assert "queue held" not in person.said
        person.type("go 3\n")  # Its alarm is acknowledged now.
        await person.until("queue: 7, 3")


async def test_a_battery_that_was_low_and_is_unreadable_asks_as_well() -> None:
    async with at_four_percent() as (person, battery):
        station = person.station
        battery.status.percentage, battery.status.battery_health = math.nan, ""
        await until(lambda: station.robot.snapshot.battery.percentage is None)
        person.type("go 12\nalarms\n")
        await person.until("failed: go: The battery is low. Send all the same?")
        await person.until("LOW BATTERY 4.0 %: dock the robot (last known)")
        assert station.robot.snapshot.goal is None


async def test_a_held_queue_is_not_continued_unasked_while_it_charges() -> None:
    async with at_four_percent(charges=True) as (person, battery):
        await person.enter("go 12", f"failed: go: {QUESTION.format(', charging', 'Send')}")
        person.type("go 12 7 --yes\ncancel\n")
        await person.until("queue held: 7 (cancelled)")
        await person.enter(
            "continue", f"failed: continue: {QUESTION.format(', charging', 'Continue')}"
        )
        battery.status.percentage, battery.status.battery_health = 90.0, "good"
        robot = person.station.robot
        await until(lambda: robot.snapshot.battery.percentage == 90.0)
        await person.enter("continue", "go to shelf 7: accepted")


async def test_keys_are_asked_too() -> None:
    async with console(*LONG, node_makers=[MotorController, Battery], wait=False) as op:
        await op.until("LOW BATTERY 4.0 %")
        await op.press("g", *"12 7", "enter")
        await op.until("The battery is low, 4.0 %. Send all the same?")
        await op.press("escape")
        assert op.app.view.snapshot.goal is None
        await op.press("escape", "G", *"shelf", "enter")
        await op.until("Shelf ")
        op.send("7", "enter", "enter")  # As one that is held down.
        await op.until("Send all the same? Then send it again.")
        assert op.app.view.snapshot.goal is None
        await op.press("escape", "g", *"12 7", "enter")
        await op.until("The battery is low, 4.0 %. Send all the same?")
        await op.press("s", "enter")
        await op.until("MOVING to 12")
        assert "then 7" in op.text
