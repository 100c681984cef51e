"""Nothing is assumed: ARCHO's stories on a robot whose every name, type and field differs."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

pytest.importorskip("depot_interfaces")

from typing import Any

from depot_interfaces.action import Haul
from depot_interfaces.msg import CellState, DriveState
from depot_interfaces.srv import Halt, Plug, Zero
from rclpy.node import Node

from tests.support.console import Console, console
from tests.support.plain import plain
from tests.support.stand_in import Drive, Made

TRACK = 20.0  # m


class Power(Node):
    """Its battery; `level` is what it says next."""

    def __init__(self, **options: Any) -> None:
        super().__init__("power", **options)
        self.declare_parameter("weak_below", 30.0)
        self.level, self.filling = 80.0, False
        self._publisher = self.create_publisher(CellState, "cell", 10)
        self.create_service(Plug, "plug", self._on_plug)
        self.create_timer(0.2, self._tell)

    def _tell(self) -> None:
        weak = self.level < self.get_parameter("weak_below").value
        verdict = "weak" if weak else "fine"
        said = CellState(level=self.level, potential=36.5, filling=self.filling, verdict=verdict)
        self._publisher.publish(said)

    def _on_plug(self, request: Any, response: Any) -> Any:
        self.filling = request.connected
        response.done = True
        return response


class Hauler(Node):
    """Its drive: 2 m every 0.1 s, to bays 1 .. 4."""

    def __init__(self, **options: Any) -> None:
        super().__init__("hauler", **options)
        self.declare_parameter("track", TRACK)
        self.turns, self.latched = 400, False
        words = {"succeed": "at the bay", "canceled": "called back", "abort": "halted"}
        self.drive = Drive(
            self,
            Haul,
            "haul",
            "to_go",
            way=TRACK,
            step=2.0,
            accepts=self._accepts,
            result=lambda how: {"words": words[how]},
        )
        self._publisher = self.create_publisher(DriveState, "wheels", 10)
        self.create_service(Zero, "zero_turns", self._on_zero)
        self.create_service(Halt, "halt", self._on_halt)
        self.create_service(Halt, "unhalt", self._on_unhalt)
        self.create_timer(0.1, self._tell)

    def _tell(self) -> None:
        moving = self.drive.goal is not None
        said = DriveState(turns=self.turns, velocity=2.0 * moving, rolling=moving)
        said.latched = self.latched
        self._publisher.publish(said)
        self.turns += 10 * moving

    def _accepts(self, goal: Any) -> bool:
        is_refused = self.latched or goal.bay > 4
        if is_refused:
            self.get_logger().warning("No: latched" if self.latched else f"No: no bay {goal.bay}")
        return not is_refused

    def _on_zero(self, request: Any, response: Any) -> Any:
        self.turns = 0
        response.done, response.note = True, "counted from zero"
        return response

    def _on_halt(self, request: Any, response: Any) -> Any:
        self.latched = response.halted = True
        self.drive.end("abort")
        return response

    def _on_unhalt(self, request: Any, response: Any) -> Any:
        self.latched, response.halted = False, True
        return response


FILE = Path(__file__).with_name("tug.yaml")


@asynccontextmanager
async def tug() -> AsyncIterator[tuple[Console, Power, Hauler]]:
    """The console, and the tug's nodes."""
    power, hauler = Made(Power), Made(Hauler)
    async with console(robot=FILE, node_makers=[power, hauler], wait=False) as op:
        await op.until(lambda: len(op.app.view.snapshot.offered) == 7)
        await op.until("● online")
        await op.until(lambda: op.app.view.snapshot.low_charge == 30.0)
        yield op, power.node, hauler.node


async def test_it_has_its_name_readings_and_words_is_sent_and_refuses() -> None:
    async with tug() as (op, _, _):
        assert " TUG " in op.line("online")
        await op.until(lambda: "● GOOD 80.0 % 36.5 V" in op.words)
        await op.until("low 30")
        await op.until("400 turns  0.00 m/s")
        assert "2 Drive" in op.text
        assert "3 Haul to bay" in op.text
        assert "Bay" in op.line("Go    Cancel")
        assert "Press g, type the bay, press enter." in op.text
        await op.press("g", "3", "enter")
        await op.until("MOVING to 3")
        await op.until("m left of 20.0 m")
        await op.until("✓ ARRIVED")
        assert "at the bay, 20.0 m in" in op.line("✓ ARRIVED")
        assert "✓ 3 arrived" in op.text
        await op.until("haul to bay 3: accepted")
        await op.press("g", "7", "enter")
        await op.until("✗ REFUSED")
        assert "no bay 7" in op.line("✗ REFUSED")
        await op.press("g", "1", "2", "enter")
        await op.until("Bay: at most 9, not 12")
        assert [goal.target for goal in op.app.view.snapshot.history] == ["7", "3"]


async def test_it_is_cancelled_and_halted_on_the_way_and_its_release_asks() -> None:
    async with tug() as (op, _, hauler):
        hauler.drive.step = 0.1  # It is on its way for 20 s.
        await op.press("g", "3", "enter")
        await op.until("m left of")
        await op.press("ctrl+c")
        await op.until("✗ CANCELLED")
        assert "called back," in op.line("✗ CANCELLED")
        assert "m before bay 3" in op.line("✗ CANCELLED")
        await op.press("g", "3", "enter")
        await op.until("m left of")
        await op.press("escape", "5", "home", "s")
        await op.until("and /hauler serves halt and haul.")
        await op.press("escape", "ctrl+x")
        await op.until("✗ STOPPED")
        assert hauler.latched
        await op.until("✗ ABORTED")
        await op.press("escape", "R")
        await op.until("Release the stop?")
        await op.press("y")
        await op.until("● IDLE")
        assert not hauler.latched


async def test_its_commands_have_their_keys_and_ask_and_a_low_battery_its_own() -> None:
    async with tug() as (op, power, hauler):
        hauler.drive.step = 0.1
        await op.press("z")
        await op.until("zero turns: counted from zero")
        assert hauler.turns == 0
        await op.press("p")
        await op.until("CHARGING")
        assert power.filling
        await op.press("p")
        await op.until("unplug: done")
        assert not power.filling
        await op.press("g", "3", "enter")
        await op.until("m left of")
        await op.press("escape", "z")
        await op.until("The robot is on its way to bay 3. Zero turns now?")
        await op.press("escape")
        power.level = 20.0
        await op.until("LOW BATTERY 20.0 %: dock the robot, or press p to charge")
        await op.press("a")
        await op.until(lambda: "(a acknowledge)" not in op.text)


async def test_it_is_operated_line_by_line() -> None:
    code, text = await plain("help\nstatus\nplug\nunplug\nzero\ngo 3\n", Power, Hauler, robot=FILE)
    assert code == 0
    for part in (
        "go N ...: Haul to bay",
        "plug: Plug in",
        "battery GOOD, 80.0 %, 36.5 V",
        "plug in: done",
        "unplug: done",
        "zero turns: counted from zero",
        "ARRIVED, bay 3, at the bay, 20.0 m in",
    ):
        assert part in text, text
