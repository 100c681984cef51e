"""Encoder, stop, parameters, battery, focus, help: an operator at the keyboard."""

from __future__ import annotations

import re
import threading
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.screen.keyed_app import HELD
from archo_tui.screen.widgets.battery_panel import BatteryPanel
from archo_tui.session.session import _robots_nodes
from tests.support.clock import seconds, stuck
from tests.support.console import FAST, LONG, console
from tests.support.night import corners


async def test_r_resets_c_charges_and_a_goal_is_refused_while_stopped() -> None:
    async with console(*FAST) as op:
        await op.until("15 420 ticks")
        await op.press("2", "enter")  # the panel alone does nothing
        await op.settle()
        assert not [event for event in op.app.view.snapshot.events if event.level == "YOU"]
        await op.press("tab", "enter")  # its button
        await op.until("        0 ticks")
        await op.press("escape", "g", "6", "enter")
        await op.until("Arrived at shelf 6")
        await op.until(lambda: "        0 ticks" not in op.text)
        await op.press("escape", "r")
        await op.until("        0 ticks")
        await op.until("reset encoder: Encoder reset to zero")

        await op.press("c")
        await op.until("↯ CHARGING")
        await op.press("c")
        await op.until("● GOOD")

        await op.press("ctrl+x")
        await op.until("✗ STOPPED")
        await op.press("g", "7", "enter")
        refused = re.compile(r"✗ REFUSED +at \d\d:\d\d:\d\d: emergency stop: release it first")
        await op.until(lambda: refused.search(op.text))


async def test_r_asks_while_a_goal_runs_and_the_safe_answer_has_the_focus() -> None:
    async with console(*LONG) as op:
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.press("escape", "r")
        await op.until("The robot is on its way to shelf 12. Reset encoder now?")
        assert op.app.focused is not None
        assert op.app.focused.id == "answer-0"
        await op.press("enter")
        await op.until(lambda: op.app.screen is op.app.main)
        assert "        0 ticks" not in op.text
        await op.press("r")
        await op.until("Reset encoder now?")
        await op.press("tab", "enter")
        await op.until("reset encoder: Encoder reset to zero")
        await op.press("ctrl+c")


@pytest.mark.parametrize("where", corners(["field", "question"], ["main", "edit dialog", "help"]))
async def test_stop_acts_everywhere_and_is_released_apart(where: str) -> None:
    async with console(*LONG) as op:
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.press("7" if where == "field" else "escape")
        if where == "edit dialog":
            await op.press("4", "enter")
            await op.until(lambda: op.app.screen is not op.app.main)
        if where == "question":
            await op.press("r")
            await op.until("Reset encoder now?")
        if where == "help":
            await op.press("question_mark")
            await op.until("Keys")
        await op.press("ctrl+x")
        await op.until(lambda: op.app.view.snapshot.motion.stopped)
        while op.app.screen is not op.app.main:
            await op.press("escape")
        await op.until("✗ ABORTED      Emergency stop, ")
        if where == "field":  # Behind the 7, R would be text.
            await op.until("✗ STOPPED (esc R releases)")
            await op.until("STOPPED: look for the cause, then press esc R to release")
            await op.press("escape")
        await op.until("✗ STOPPED (R releases)")
        await op.until("STOPPED: look for the cause, then press R to release")
        await op.at(seconds() + HELD)  # what comes at once may be for the dialog that has gone
        await op.press("R")
        await op.until("Release the stop?")
        await op.press("tab", "enter")
        await op.until("● IDLE")


class Sleeper(Node):
    """A node whose callback does not return for a long time."""

    awake = threading.Event()

    def __init__(self, **options: Any) -> None:
        super().__init__("sleeper", **options)
        self.create_timer(0.01, self.sleep)

    def sleep(self) -> None:
        with stuck():
            self.awake.wait(30)


async def test_a_node_that_hangs_does_not_hang_the_keyboard() -> None:
    Sleeper.awake.clear()
    async with console(*FAST, node_makers=[*_robots_nodes(False).values(), Sleeper]) as op:
        try:
            await op.press("g", "8", "enter")
            await op.until("Arrived at shelf 8")
        finally:
            Sleeper.awake.set()


async def test_bars_fit_every_new_size_at_once_and_nodes_tick_on_behind_dialogs() -> None:
    async with console(*FAST) as op:
        for width, height in ((80, 24), (120, 36), (80, 24), (160, 48)):
            await op.pilot.resize_terminal(width, height)
            await op.settle()
            bar = op.line("░░░").strip("│").partition("│")[0].strip()
            assert len(bar) == op.app.main.query_one("#battery-gauge").size.width

        monitor = op.session.host.nodes[0].node
        ticks = [0]
        publish = monitor.publisher.publish  # type: ignore[attr-defined]

        def counted(message: Any) -> None:
            ticks[0] += 1
            publish(message)

        monitor.publisher.publish = counted  # type: ignore[attr-defined]
        await op.press("4", "enter")
        for width, height in ((80, 24), (160, 48), (40, 10), (120, 36)):
            await op.pilot.resize_terminal(width, height)
            wanted = ticks[0] + 2
            await op.until(lambda wanted=wanted: ticks[0] >= wanted)  # type: ignore[misc]
        await op.press("escape")
        await op.until("1 Battery")


async def test_quitting_with_a_goal_running_asks_cancels_and_goes() -> None:
    # a cancel takes up to a second here: quitting waits for the end
    async with console("-p", "feedback_period:=1.0", "-p", "time_scale:=1.0") as op:
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.press("ctrl+q")
        await op.until("The robot is on its way to shelf 12.")
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)
        await op.press("ctrl+q")
        await op.until("Cancel goal and quit")
        await op.press("tab", "enter")
        await op.until(lambda: not op.app.is_running)
        goal = op.session.robot.snapshot.goal
        assert goal is not None
        assert goal.message == "Cancelled mid-route"
        assert op.app.return_code == 0


async def test_quitting_leaves_no_thread_behind() -> None:
    before = set(threading.enumerate())
    async with console(*FAST) as op:
        assert len(set(threading.enumerate()) - before) >= 4
        await op.press("q")
        await op.until(lambda: not op.app.is_running)
    left = {t.name for t in set(threading.enumerate()) - before if not t.name.startswith("asyncio")}
    assert left == set()


async def test_a_panel_that_cannot_be_drawn_says_so_and_stop_works() -> None:
    async with console(*LONG) as op:
        battery = next(panel for panel in op.app.query(BatteryPanel))
        draws = battery.show

        def break_down(_: object) -> None:
            raise ZeroDivisionError("nothing to divide")

        battery.show = break_down  # type: ignore[method-assign,assignment]
        await op.until("1 Battery   ✗ cannot be drawn")
        assert "GOOD" not in op.text
        await op.until("panel 1 cannot be drawn: ZeroDivisionError: nothing to divide")
        await op.press("g", "3", "enter")
        await op.until("▶ MOVING")
        await op.press("ctrl+x")
        await op.until("✗ STOPPED")
        battery.show = draws  # type: ignore[method-assign]
        await op.until(lambda: "cannot be drawn" not in op.line("1 Battery"))
