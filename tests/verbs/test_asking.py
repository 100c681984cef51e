"""What a verb asks: a person at a terminal answers; anybody else is told of `--yes`."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from archo_bringup.motor_controller import MotorController
from archo_interfaces.msg import BatteryStatus
from rclpy.node import Node

from archo_tui.base.clock import Clock
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.verbs.verb import Question
from tests.support import clock
from tests.support.console import LONG, console
from tests.support.plain import Typed, operated, typing
from tests.support.quiet import until
from tests.support.robot import making
from tests.support.states import STATES, goal
from tests.support.stub import Willing, stub_station

pytestmark = pytest.mark.posix


QUESTION = "Release the stop? Moves are allowed again; nothing resumes by itself. [y/N]"

NOT_DONE = "failed: release: not done: the answer was not yes"


def willing(snapshot: Snapshot) -> Willing:
    """It accepts every verb, and none of its goals has failed."""
    return Willing(snapshot._replace(history=()))


def at_terminal(robot: Any) -> Any:
    """A person at a terminal."""
    return typing(stub_station(robot, clock.current or Clock()), at_terminal=True)


async def test_only_a_yes_at_a_terminal_does_it() -> None:
    robot = willing(STATES["motor stopped"])
    async with at_terminal(robot) as person:
        for number, answer in enumerate(("n", "NO", "", "  "), 1):
            person.type(f"release\n{answer}\n")
            await until(lambda n=number: person.said.count(NOT_DONE) == n)  # type: ignore[misc]
            assert robot.told == []
        person.type("\n\n")  # A return between two lines answers nothing.
        for number, answer in enumerate(("y", "YES", " yes "), 1):
            await person.enter("release", QUESTION)
            person.type(f"{answer}\n")
            await until(lambda n=number: len(robot.told) == n)  # type: ignore[misc]
        assert set(robot.told) == {"release_emergency_stop"}


VOID = "failed: release: not sent: STOP came after it"


@pytest.mark.parametrize(
    ("typed", "said", "then", "told"),
    [
        ("", "", NOT_DONE, []),  # The end of the input.
        ("", "reset\n", NOT_DONE, ["command"]),  # Another verb is done.
        ("y\nstop\n", "", VOID, ["emergency_stop"]),
        ("stop\n", "release\ny\n", VOID, ["emergency_stop", "release_emergency_stop"]),
    ],
)
async def test_what_is_no_yes_releases_nothing(
    typed: str, said: str, then: str, told: list[str]
) -> None:
    robot = willing(STATES["motor stopped"])
    async with at_terminal(robot) as person:
        await person.enter("release", QUESTION)
        if typed:
            person.type(typed)
            await person.until(then)
        first, *more = said.splitlines(keepends=True) or [""]
        for line in more:
            await person.enter(first.strip(), f"{QUESTION}\n")
            first = line
        assert await person.end(first) == 1
        assert then in person.said
        assert robot.told == told


def test_a_question_is_over_with_its_goal_that_was_on_its_way() -> None:
    shown = goal(Phase.MOVING, number=1).running_goal
    assert shown is not None
    sent = shown._replace(number=0, phase=Phase.SENT)
    question = Question("Reset", "Reset encoder now?", "No", "Yes", sent)
    assert not question.is_over(sent)
    assert not question.is_over(shown)
    assert question.is_over(shown._replace(fields={"shelf": 99}))
    assert question.is_over(None)


async def test_what_a_file_would_change_is_listed_before_the_question(here: Any) -> None:
    (here / "a.yaml").write_text(
        "motor_controller:\n  ros__parameters:\n    max_speed: 0.7\n    nosuch: 1\n"
    )
    async with operated(at_terminal=True) as person:
        await person.enter("load a.yaml", "Change 1 parameter? [y/N]")
        change = "motor_controller max_speed: 0.8, would be 0.7"
        assert f"a.yaml\n{change}\nleft out: a.yaml:4: " in person.said
        assert await person.end("n\n") == 1
        assert "max_speed is 0.7" not in person.said


LOW = "The battery is low, 4.0 %{}. {} all the same? (add --yes to do it)\n"


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
        await person.until(f"failed: go: {LOW.format('', 'Send')}")
        await person.until(f"failed: send_goal: {LOW.format('', 'Send')}")
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
        await person.enter("go 12", f"failed: go: {LOW.format(', charging', 'Send')}")
        person.type("go 12 7 --yes\ncancel\n")
        await person.until("queue held: 7 (cancelled)")
        await person.enter("continue", f"failed: continue: {LOW.format(', charging', 'Continue')}")
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
