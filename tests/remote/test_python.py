"""`archo_tui.connect()`: every method, and the error that each end is."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node

import archo_tui
from archo_tui.errors import ArchoError
from archo_tui.remote.api import (
    Aborted,
    Cancelled,
    Misused,
    NotDone,
    RanOut,
    Refused,
    Robot,
    Unreached,
)
from tests.support.console import FAST, LONG
from tests.support.plain import Typed
from tests.support.shells import heard, served, typed

pytestmark = pytest.mark.real_time


async def does(work: Callable[[Robot], Any]) -> Any:
    """What a program gets from a robot of its own connection."""

    def run() -> Any:
        with archo_tui.connect() as robot:
            return work(robot)

    return await asyncio.to_thread(run)


async def test_the_state_is_typed_and_measured() -> None:
    async with served(ros_args=FAST):
        status = await does(lambda robot: robot.status())
        assert status.robot == "ARCHO"
        assert 0 < status.battery.percentage <= 100
        assert (status.battery.source, status.motion.word) == ("measured", "IDLE")
        assert (status.goal, status.alarms, status.queue.waiting) == (None, [], [])
        goal = await does(lambda robot: robot.go(12, 7))
        assert (goal.name, goal.code, goal.values) == ("shelf 7", "arrived", {"shelf_number": 7})
        assert (await does(lambda robot: robot.status())).goal.code == "arrived"


async def test_parameters_are_read_and_set_in_their_types() -> None:
    def change(robot: Robot) -> Any:
        robot.set("motor_controller", "max_speed", 0.5)
        return robot.get("motor_controller", "max_speed")

    async with served(ros_args=FAST):
        assert await does(change) == 0.5


class Named(Node):
    """Has a list of texts."""

    def __init__(self, **given: Any) -> None:
        super().__init__("named", **given)
        self.declare_parameter("names", ["one"])


async def test_a_list_of_texts_is_set_as_it_is_whatever_its_letters() -> None:
    def change(robot: Robot) -> Any:
        robot.set("named", "names", ["\N{ROBOT FACE}", "caf\N{LATIN SMALL LETTER E WITH ACUTE}"])
        return robot.get("named", "names")

    async with served(Named):
        assert await does(change) == ["\N{ROBOT FACE}", "caf\N{LATIN SMALL LETTER E WITH ACUTE}"]


async def test_a_goal_that_is_not_waited_for_can_be_waited_for_later() -> None:
    def drive(robot: Robot) -> None:
        assert robot.go(12, wait=False) is None
        robot.wait("arrived")
        robot.wait("idle")
        robot.wait("arrived")  # it has long been there
        robot.wait("ready", timeout=1)

    async with served(ros_args=FAST):
        await does(drive)


async def test_after_the_events_were_left_the_next_call_is_answered() -> None:
    def listen(robot: Robot) -> list[str]:
        robot.go(12, wait=False)
        found = []
        for event in robot.events():
            found.append(event["text"])
            if event["text"].startswith("Arrived"):
                break
        assert robot.status().goal is not None
        return found

    async with served(ros_args=FAST):
        assert "Arrived at shelf 12" in await does(listen)


@pytest.mark.parametrize(
    ("work", "error", "code"),
    [
        (lambda robot: robot.go(99), Refused, "refused"),
        (lambda robot: robot.go("there"), Misused, "misuse"),
        (lambda robot: robot.cancel(), Refused, "refused"),
        (lambda robot: robot.do("jump"), Misused, "misuse"),
        (lambda robot: robot.wait("battery", 101, timeout=0), RanOut, "ran_out"),
        (lambda robot: robot.wait("idle", timeout=float("nan")), Misused, "misuse"),
        (lambda robot: archo_tui.connect("1"), Unreached, "unreached"),
    ],
)
async def test_each_end_is_an_error_of_its_own(
    work: Callable[[Robot], Any], error: type[NotDone], code: str, unlimited: Path
) -> None:
    async with served(robot=unlimited, ros_args=FAST):
        with pytest.raises(error) as raised:
            await does(work)
        assert raised.value.code == code
        assert isinstance(raised.value, ArchoError)


async def moving(person: Typed) -> asyncio.Task[Any]:
    drive = asyncio.ensure_future(does(lambda robot: robot.go(12)))
    await heard(person, "MOVING to 12")
    return drive


async def test_a_goal_that_ends_otherwise_raises() -> None:
    async with served(ros_args=LONG) as person:
        drive = await moving(person)
        await typed("cancel")
        with pytest.raises(Cancelled, match="Cancelled mid-route"):
            await drive
    async with served(ros_args=LONG) as person:
        drive = await moving(person)
        await does(lambda robot: robot.stop())
        with pytest.raises(Aborted):
            await drive
        with pytest.raises(Misused, match="add --yes to do it"):
            await does(lambda robot: robot.do("release"))


async def test_leaving_the_with_block_by_an_error_cancels_what_it_waits_for() -> None:
    async with served(ros_args=LONG) as person:
        robot = await asyncio.to_thread(archo_tui.connect)
        drive = asyncio.ensure_future(asyncio.to_thread(robot.go, 12))
        await heard(person, "MOVING to 12")
        connected, _ = robot._connection.handed_over()
        connected.shutdown(2)
        with pytest.raises(Unreached, match="the robot may still be moving"):
            await drive
        robot.close()
        await heard(person, "CANCELLED")


def test_without_a_console_nothing_is_reached() -> None:
    with pytest.raises(Unreached, match="no console runs here"):
        archo_tui.connect()
