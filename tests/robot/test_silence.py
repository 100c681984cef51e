"""A robot that says too little for its period to be known: when it counts as silent."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float32

from tests.support import clock
from tests.support.clock import seconds
from tests.support.plain import Typed, operated
from tests.support.quiet import until

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Teller(Node):
    """Says its charge at the start, and again each so many s, if any."""

    def __init__(self, again: float = 0.0, qos: Any = 10, **options: Any) -> None:
        super().__init__("teller", **options)
        self.battery = self.create_publisher(Float32, "battery_level", qos)
        self.first = self.create_timer(1.5, self.begin)  # when the console has found it
        if again:
            self.create_timer(again, self.tell)

    def begin(self) -> None:
        self.first.cancel()
        self.tell()

    def tell(self) -> None:
        self.battery.publish(Float32(data=42.0))


async def state(person: Typed, after: float) -> str:
    """What `status` says about so many s after the battery was last heard."""
    robot, before = person._plain._station.robot, len(person.said)
    await until(lambda: seconds() > (robot.snapshot.battery.received or seconds()) + after)
    person.type("status\n")
    await person.until("\ngoal ")
    return person.said[before:]


async def test_nodes_that_were_heard_once_and_were_stopped_are_lost() -> None:
    async with operated() as person:
        robot = person._plain._station.robot
        await until(lambda: robot.snapshot.battery.received and robot.snapshot.motion.received)
        assert robot.snapshot.battery.period is None
        person.type("halt battery_monitor\nhalt motor_controller\n")
        await person.until("alarm unacknowledged: CONTACT LOST for ")
        assert "battery GOOD, 87.5 %, old, " in await state(person, 5.0)


async def test_what_is_heard_once_is_old_after_30_s_though_its_node_is_there() -> None:
    async with operated(Teller) as person:
        assert "battery GOOD, 42.0 %\n" in await state(person, 28.0)
        assert "CONTACT LOST" not in person.said
        assert "battery GOOD, 42.0 %, old, " in await state(person, 31.0)
        assert "alarm unacknowledged: CONTACT LOST for " in person.said


@pytest.mark.parametrize("maker", [partial(Teller, 10.0), partial(Teller, qos=LATCHED)])
async def test_who_speaks_rarely_or_says_what_holds_is_not_silent(maker: Any) -> None:
    async with operated(maker) as person:
        # in real time long enough for one silence of 10 s
        later = seconds() + (15.0 if clock.current is None else 60.0)
        await until(lambda: seconds() > later)
        person.type("status\n")
        await person.until("battery GOOD, 42.0 %\n")
        assert "CONTACT LOST" not in person.said


async def test_a_console_that_was_suspended_with_its_nodes_has_lost_nobody() -> None:
    if clock.current is None:
        pytest.skip("real time passes for all")
    async with operated() as person:
        robot = person._plain._station.robot
        later = seconds() + 5.0
        await until(lambda: seconds() > later)
        assert robot.snapshot.battery.period == 1.0
        clock.current.suspend(6.0)
        assert person._plain._station.tick() == []  # the first to go on, before the nodes
        later = seconds() + 5.0
        await until(lambda: seconds() > later)
        assert "alarm" not in person.said


async def test_what_holds_is_old_when_its_node_has_left() -> None:
    async with operated(partial(Teller, qos=LATCHED)) as person:
        await until(lambda: person._plain._station.robot.snapshot.battery.received)
        person.type("halt teller\n")
        await person.until("alarm unacknowledged: CONTACT LOST for ")
