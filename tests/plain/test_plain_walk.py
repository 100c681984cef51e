"""Lines at random with STOP among them: after the last one nothing moves, nothing is released."""

from __future__ import annotations

import random
from typing import Any

import pytest
from archo_bringup.battery_monitor import BatteryMonitor
from archo_bringup.motor_controller import MotorController

from tests.robots.cart import Cart
from tests.support import clock
from tests.support.console import LONG
from tests.support.plain import Typed, operated
from tests.support.quiet import Quiet
from tests.support.walks import Counting, length
from tests.terminal.test_stop_is_final import ROBOTS

_LINES = [
    *(
        "go 12",
        "go 12 7 3",
        "go 99",
        "go x",
        "cancel",
        "release --yes",
        "continue",
        "skip",
        "reset",
    ),
    *("set motor_controller max_speed 0.5", "set nosuch x 1", "blink", "status", "", "nonsense"),
    *("charge", "go 7\r", '"open', "params", "x" * 300),
]
_STOPS = ["stop", "STOP!", "Stop.", " stop now", '"stop"', "stop\r", "\ufeffstop"]


async def walk(person: Typed, seed: int, rounds: int, made: list[Any], stands: Any) -> None:
    """Rounds of lines that end with STOP; `stands()` is what must hold then."""
    choose = random.Random(seed)
    await Quiet().until(lambda: made, lambda: "the robot")
    typed: list[str] = []

    async def pause(seconds: float) -> None:
        end = clock.seconds() + seconds
        await person.is_read()
        await Quiet().until(lambda: clock.seconds() >= end, lambda: f"{seconds} s")

    for number in range(rounds):
        if choose.random() < 0.5:
            person.type("release --yes\ngo 12\n")
            await pause(1.0)
        for _ in range(choose.randrange(4)):
            lines = choose.choices(_LINES, k=choose.randrange(1, 5))
            if choose.random() < 0.3:
                lines.insert(choose.randrange(len(lines) + 1), choose.choice(_STOPS))
            typed.append("\n".join(lines) + "\n")
            person.type(typed[-1])
            if choose.random() < 0.5:
                await pause(choose.choice([0.0, 0.1, 0.7]))
        before = choose.choices(_LINES, k=choose.randrange(4))
        typed.append("\n".join([*before, choose.choice(_STOPS), "status", ""]))
        person.type(typed[-1])
        await pause(4.0)
        assert stands(), f"seed {seed}, round {number}: {typed[-6:]}\n{person.said[-3000:]}"


@pytest.mark.parametrize("which", [1])
async def test_after_the_last_stop_line_a_robot_that_latches_stays_stopped(
    which: int, request: pytest.FixtureRequest
) -> None:
    made: list[Counting] = []

    def motor(**given: Any) -> MotorController:
        made.append(Counting(**given))
        return made[-1]

    async with operated(BatteryMonitor, motor, ros_args=LONG) as person:
        await walk(
            person,
            *length(which, request),
            made,
            lambda: made[0].emergency_stopped and made[0].goal is None,
        )
        assert made[0].driven


@pytest.mark.parametrize("which", [3])
async def test_after_the_last_stop_line_a_robot_that_does_not_latch_stands(
    which: int, request: pytest.FixtureRequest
) -> None:
    made: list[Cart] = []

    def cart(**given: Any) -> Cart:
        made.append(Cart(**given))
        return made[-1]

    async with operated(cart, robot=ROBOTS / "cart.yaml") as person:
        await walk(person, *length(which, request), made, lambda: made[0].drives == 0)
        assert made[0].driven
