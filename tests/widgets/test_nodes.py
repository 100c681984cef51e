"""Nodes are started, stopped and copied; none needs another."""

from __future__ import annotations

from functools import partial
from typing import Any

from rclpy.node import Node

from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.session.session import _robots_nodes
from archo_tui.text.nodes import NodeRow
from archo_tui.text.state import motion_word
from tests.support.clock import NOW
from tests.support.console import FAST, LONG, Console, console
from tests.support.stand_in import StandIn
from tests.support.states import NORMAL, STATES, plain_text


async def select(op: Console, name: str) -> None:
    """Put the cursor on a node."""
    await op.press("5", "home")
    await op.until(lambda: op.app.main.nodes.selected)
    for _ in range(50):
        selected = op.app.main.nodes.selected
        if selected is not None and selected.name == name:
            return
        await op.press("down")
    raise AssertionError(f"no {name}:\n{op.text}")


async def test_without_the_battery_monitor_the_gauge_goes_old_and_recovers() -> None:
    async with console(*FAST) as op:
        await select(op, "/battery_monitor")
        await op.press("s")
        await op.until("○ battery_monitor  stopped by you")
        await op.until("stop /battery_monitor: /battery_monitor stopped")
        await op.until("(old, 3 s)")
        await op.press("g", "7", "enter")
        await op.until("Arrived at shelf 7")  # the motor does not notice
        await op.press("escape")
        await select(op, "/battery_monitor")
        await op.press("s")
        await op.until("● battery_monitor")
        await op.until(lambda: "old" not in op.line("GOOD") and op.line("GOOD"))


def test_what_is_silent_or_does_not_run_publishes_nothing_now() -> None:
    state = NORMAL.nodes[0]
    heard, rate = state.heard, state.rate
    assert heard is not None
    often = f"{rate:.1f} Hz"
    for life, ago, said in (
        (Life.UP, 0.5, often),
        (Life.UP, 9.0, f"nothing now, {often} before"),
        (Life.CRASHED, 0.5, f"nothing now, {often} before"),
    ):
        row = NodeRow(state, Hosted(state.name, life), heard + ago)
        assert f"publishes   {said}\n" in row.details(heard + ago, NORMAL)


def test_while_contact_is_lost_no_node_elsewhere_looks_healthy() -> None:
    dashboard = next(node for node in NORMAL.nodes if node.rate is None)
    assert dashboard.heard is not None
    now = dashboard.heard + 9.0
    assert NodeRow(dashboard, None, now).word()[0] == "●"  # it says something when there is news
    assert NodeRow(dashboard, None, now, is_lost=True).word()[:2] == ("?", "contact lost")
    assert NodeRow(dashboard, Hosted(dashboard.name), now, is_lost=True).word()[0] == "●"


def test_where_stop_cannot_be_sent_the_motor_says_so() -> None:
    for state, why in (
        ("battery of another type", "no STOP: /emergency_stop is std_srvs/srv/SetBool"),
        ("nothing offered", "no STOP: emergency_stop is not offered by any node"),
    ):
        assert why in plain_text(motion_word(STATES[state], NOW, 200))
    assert plain_text(motion_word(NORMAL, NOW, 200)) == "● IDLE"


async def test_ten_dashboards_and_nobody_notices() -> None:
    async with console(*FAST, size=(120, 60)) as op:
        await select(op, "/dashboard")
        for _ in range(9):
            await op.press("plus")
        await op.until("● dashboard_10")
        states = op.app.station.host.states()
        assert sum(s.name.startswith("/dashboard") and s.life is Life.UP for s in states) == 10
        await op.until(
            lambda: (
                sum(n.name.startswith("/dashboard") and n.heard is not None for n in _nodes(op))
                == 10
            )
        )
        await op.press("g", "7", "enter")
        await op.until("Arrived at shelf 7")


def _nodes(op: Console) -> Any:
    return op.app.view.snapshot.nodes


async def test_stopping_what_drives_is_asked_about_alone_and_its_goal_is_lost() -> None:
    async with console(*LONG) as op:
        await op.press("g", "1", "2", "enter")
        await op.until("m left of")
        await op.press("escape", "5", "home", "s")
        await op.until("○ battery_monitor  stopped by you")
        await select(op, "/motor_controller")
        await op.press("s")
        await op.until("serves")
        await op.press("enter")
        await op.until(lambda: op.app.screen is op.app.main)
        assert op.text.count("○ ") == 1
        await op.press("s")
        await op.until("Stop the node?")
        await op.press("tab", "enter")
        await op.until("○ motor_controller stopped by you")
        await op.until("✗ LOST         the robot may still be moving")


async def test_stopping_what_only_serves_stop_is_asked_about_in_a_move() -> None:
    driver, brake = partial(StandIn, "driver", goals="drive"), partial(StandIn, "brake", "yes")
    async with console(node_makers=[driver, brake], wait=False) as op:
        wanted = {"move_to_shelf", "emergency_stop"}
        await op.until(lambda: op.app.view.snapshot.offered >= wanted)
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.press("escape")
        await select(op, "/brake")
        await op.press("s")
        await op.until("and /brake serves")
        await op.until("emergency_stop. Stop the node?")
        await op.press("enter")  # the safe answer
        await op.settle()
        assert "stopped by you" not in op.text


class Fragile(Node):
    """Fails when it is told to."""

    def __init__(self, **options: Any) -> None:
        super().__init__("fragile", **options)
        self.declare_parameter("divisor", 1)
        self.create_timer(0.01, self.divide)

    def divide(self) -> None:
        1 / self.get_parameter("divisor").value


async def test_a_crashed_node_says_why_and_is_started_again() -> None:
    async with console(*FAST, node_makers=[*_robots_nodes(False).values(), Fragile]) as op:
        await op.until(lambda: op.app.view.snapshot.parameter("divisor"))
        await op.app.station.robot.set_parameters("/fragile", {"divisor": 0})
        await op.until("✗ fragile")
        await op.until("crashed: ZeroDivisionError:")
        await select(op, "/fragile")
        await op.press("enter")
        await op.until("Traceback (most recent call last):")
        await op.until("divide")  # where the line is wrapped depends on the path
        await op.press("escape", "s")
        await op.until("● fragile")
        await op.until(lambda: op.app.view.snapshot.parameter("divisor"))


async def test_another_node_that_serves_is_asked_about_and_those_elsewhere_stay() -> None:
    async with console(*FAST) as op:
        await op.press("5", "home", "plus")
        await op.until("/battery_monitor serves set_charging: a call reaches both")
        assert "STOP must" not in op.text
        await op.press("escape")

        await op.press("escape")
        other = Node("guest", context=op.session.context)
        try:
            await op.until("● guest")
            await select(op, "/guest")
            await op.press("s")
            await op.until("/guest does not run in this process")
        finally:
            other.destroy_node()

        await op.press("escape")
        await op.until("● motor_controller")
        op.send("5", "home", "down", "s")  # as over a slow link
        await op.until("○ dashboard")
        op.send("4", "home", "down", "enter")
        await op.until(" motor_controller max_speed ")

        await op.press("escape")
        await select(op, "/motor_controller")
        await op.press("plus")
        await op.until("STOP must")
        await op.press("enter")  # the safe answer
        await op.until(lambda: op.app.screen is op.app.main)
        await op.press("plus")
        await op.until("Run another")
        await op.press("tab", "enter")
        await op.until("● motor_controller_2")


HOSTILE = "\x1b]0;owned\x07\x1b[2J\u202e\u2028\u061c\U000e0041\ud800" + "a" + "\u0301" * 40


async def test_what_a_crashed_node_says_is_harmless_wherever_it_is_shown() -> None:
    class Crashes(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("crashes", **options)
            self.create_timer(0.1, self.crash)

        def crash(self) -> None:
            raise RuntimeError(HOSTILE)

    async with console(node_makers=[Crashes], wait=False) as op:
        await op.until("NODE CRASHED /crashes")
        assert_harmless(op.text)
        await op.press("5", "home", "enter")
        await op.until("RuntimeError")
        assert_harmless(op.text)


def assert_harmless(text: str) -> None:
    assert not set(text) & (set(HOSTILE) - set("]0;owned[2Ja\u0301"))
    assert "\u0301" * 5 not in text
