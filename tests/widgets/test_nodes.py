"""Panel 5, its rows, and a node's dialog: what is started, stopped, copied, offered, logged."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest
from rclpy.node import Node
from std_msgs.msg import Float32

from archo_tui.robot.state.graph import NodeState
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.robot.stop.gate import NOT_SENT
from archo_tui.screen.commands.nodes import NodeDialog
from archo_tui.screen.widgets.nodes_panel import node_columns, node_lines, node_titles
from archo_tui.session.session import _robots_nodes
from archo_tui.text.nodes import NodeRow
from archo_tui.text.state import motion_word
from tests.support.clock import NOW
from tests.support.console import FAST, LONG, Console, console
from tests.support.front import front
from tests.support.quiet import ended
from tests.support.states import NORMAL, STATES, plain_text
from tests.support.stub import StandingClock


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


HOSTILE = "\x1b]0;owned\x07\x1b[2J\u202e\u2028\u061c\U000e0041\ud800" + "a" + "\u0301" * 40


class Fragile(Node):
    """Fails when it is told to."""

    def __init__(self, **options: Any) -> None:
        super().__init__("fragile", **options)
        self.declare_parameter("divisor", 1)
        self.create_timer(0.01, self.divide)

    def divide(self) -> None:
        if not self.get_parameter("divisor").value:
            raise ZeroDivisionError(HOSTILE)


async def test_a_crashed_node_says_why_harmlessly_and_is_started_again() -> None:
    async with console(*FAST, node_makers=[*_robots_nodes(False).values(), Fragile]) as op:
        await op.until(lambda: op.app.view.snapshot.parameter("divisor"))
        await op.app.station.robot.set_parameters("/fragile", {"divisor": 0})
        await op.until("✗ fragile")
        await op.until("crashed: ZeroDivisionError:")
        assert_harmless(op.text)
        await select(op, "/fragile")
        await op.press("enter")
        await op.until("Traceback (most recent call last):")
        await op.until("divide")  # where the line is wrapped depends on the path
        assert_harmless(op.text)
        await op.press("escape", "s")
        await op.until("● fragile")
        await op.until(lambda: op.app.view.snapshot.parameter("divisor"))


async def test_another_copy_of_what_serves_stop_is_asked_about() -> None:
    async with console(*FAST) as op:
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


def assert_harmless(text: str) -> None:
    assert not set(text) & (set(HOSTILE) - set("]0;owned[2Ja\u0301"))
    assert "\u0301" * 5 not in text


async def opened(op: Console, node: str) -> None:
    """Open the dialog of a node and wait for what the graph says."""
    await select(op, node)
    await op.press("enter")
    await op.until("log level   ")


async def test_it_has_what_a_node_offers_with_types_and_leads_to_its_topics() -> None:
    async with console(*FAST) as op:
        await opened(op, "/motor_controller")
        assert "in the console's process" in op.text
        for title, name, kind in (
            ("topics published", "/motor_status", "archo_interfaces/msg/MotorStatus"),
            ("topics subscribed", "/battery_level", "archo_interfaces/msg/BatteryStatus"),
            ("services", "/emergency_stop", "archo_interfaces/srv/EmergencyStop"),
            ("services", "/release_emergency_stop", "std_srvs/srv/Trigger"),
            ("actions", "/move_to_shelf", "archo_interfaces/action/MoveToShelf"),
        ):
            below = op.text[op.text.index(title) :]
            assert re.search(rf"  {name} +{kind}", below), name
        dialog = op.text[op.text.index("/motor_controller") :]
        assert "rcl_interfaces" not in dialog
        assert "_action" not in dialog
        assert "/rosout" not in dialog

        await op.press("escape")
        await opened(op, "/motor_controller")
        await op.press("enter")
        await op.until("Topics of motor_controller")
        await op.press(*"motor_st")
        await op.press("down")  # Enter is not held.
        await op.press("enter")
        await op.until(lambda: "speed" in op.line("m/s"))
        await op.press("escape")
        await op.until("topics published")

        await op.press("escape")
        await select(op, "/battery_monitor")
        op.send(*["enter"] * 5)
        await op.until("log level   INFO")
        assert not [e for e in op.app.view.snapshot.events if e.level == "YOU"]


async def test_the_level_of_its_log_is_set_and_its_lines_follow() -> None:
    async with console(*FAST) as op:
        await opened(op, "/battery_monitor")
        await op.until("log level   INFO and above, the level of its process")
        await op.press("tab", "right", "right", "right", "right", "enter")
        await op.until("log level   ERROR and above")
        await op.press("escape")
        await op.until("log level of battery_monitor ERROR: ERROR and above, was INFO and above")
        await op.press("c")
        await op.until("✓  charge")
        await op.settle()
        sources = [event.source for event in op.app.view.snapshot.events]
        assert "battery_monitor" not in sources
        await opened(op, "/battery_monitor")
        await op.press("tab", "enter")
        await op.until("log level   INFO and above, the level of its process")
        await op.press("escape", "c")
        await op.until(
            lambda: "battery_monitor" in [event.source for event in op.app.view.snapshot.events]
        )


async def test_stop_works_in_it_and_is_final_for_a_level_set_before_it() -> None:
    async with console(*LONG) as op:
        await op.press("g", *"12", "enter")
        await op.until("MOVING to 12")
        await op.press("escape")
        await opened(op, "/motor_controller")
        await op.press("tab", "right", "ctrl+x")
        await op.until(lambda: op.app.view.snapshot.motion.stopped)
        await op.until(lambda: op.app.view.snapshot.running_goal is None)
        op.app.stops.register()  # one more, of another driver, before this is carried out
        with op.app.stops.typed_at(op.app.stops.count - 1):
            outcome = await op.app.verbs["log_level"].run(
                op.app.station, {"node": "/motor_controller", "level": "DEBUG"}
            )
        assert outcome.text == NOT_SENT


class Mute(Node):
    """Does not offer the level of its log."""

    def __init__(self, **options: Any) -> None:
        super().__init__("mute", **options)
        self.create_publisher(Float32, "noise", 1)


async def test_a_node_without_the_services_of_its_log_says_so() -> None:
    async with console(node_makers=[Mute], wait=False) as op:
        await op.until("● mute")
        await opened(op, "/mute")
        await op.until("log level   not offered by the node")
        assert "/noise  std_msgs/msg/Float32" in op.text
        assert "Debug" not in op.text


async def test_a_node_that_has_left_or_is_stopped_meanwhile_is_up_no_more() -> None:
    async with console(*FAST) as op:
        await opened(op, "/dashboard")
        snapshot = op.app.view.snapshot
        nodes = tuple(node for node in snapshot.nodes if node.name != "/dashboard")
        view = replace(op.app.view, snapshot=snapshot._replace(nodes=nodes), hosted=())
        dialog = op.app.screen
        assert isinstance(dialog, NodeDialog)

        def says_so() -> bool:
            dialog.show_view(view)  # until the next snapshot has it again
            return "? not on the graph any more" in op.text

        await op.until(says_so)

        await op.press("escape")
        await opened(op, "/dashboard")
        assert "● up" in op.text
        halted = op.app.verbs["halt"].run(op.app.station, {"node": "/dashboard"})
        assert (await ended(halted)).ok  # as from a shell, beside the dialog
        await op.until("○ stopped by you")
        assert "● up" not in op.text

        await op.press("escape", "5", "s")
        await op.until("● dashboard")
        await select(op, "/dashboard")
        await op.press("s")
        await op.until("stopped by you")
        await op.press("enter")
        await op.until("not on the graph")
        assert "log level" not in op.text


def row(name: str, rate: float | None = 5.0) -> NodeRow:
    return NodeRow(NodeState(name, NOW - 0.4, rate), None, NOW)


def drawn(rows: list[NodeRow], width: int) -> list[str]:
    columns = node_columns(rows, width)
    return [line for one in rows for line, _ in node_lines(one, width, columns)]


LONG_NAMED = row("/warehouse/level_2/motor_controller", 97.3)


@pytest.mark.parametrize("width", range(23, 60))
def test_a_rate_stands_beside_a_long_name_at_every_width(width: int) -> None:
    first, second = drawn([LONG_NAMED, row("/dashboard", None)], width)
    assert first.replace(" ", "").endswith("0.4s97.3Hz")
    assert len(first) == width
    assert first.startswith("● war")
    assert second.strip().endswith("0.4 s")


def test_a_name_that_is_cut_keeps_its_beginning_and_its_end() -> None:
    assert drawn([LONG_NAMED], 40)[0] == "● warehouse/l…r_controller 0.4 s 97.3 Hz"
    assert drawn([row("/motor_controller")], 33)[0] == "● motor_controller 0.4 s   5.0 Hz"


def test_names_are_whole_where_no_node_has_a_rate() -> None:
    assert drawn([row("/motor_controller", None)], 25)[0] == "● motor_controller  0.4 s"


def test_titles_stand_above_their_columns() -> None:
    rows = [row("/motor_controller")]
    columns = node_columns(rows, 40)
    (line, _), titles = node_lines(rows[0], 40, columns)[0], node_titles(columns)
    assert titles.startswith("  node ")
    assert len(titles) == len(line) == 40
    assert titles.index("heard") + 5 == line.index(" s") + 2
    assert titles.endswith("rate")
    assert node_titles(node_columns(rows, 0)).strip() == ""  # A hidden list.


@pytest.mark.parametrize("width", range(22, 30))
def test_a_crash_in_a_narrow_panel_names_the_exception(width: int) -> None:
    error = "ZeroDivisionError: division by zero in the callback of a timer"
    crashed = NodeRow(NodeState("/motor_controller"), Hosted("/motor", Life.CRASHED, error), NOW)
    name, line = drawn([crashed, LONG_NAMED], width)[:2]
    assert name.rstrip() == "✗ motor_controller"
    assert line.startswith("  ZeroDivisionErr")
    assert line.endswith("…")
    assert len(line) <= width


async def test_titles_are_shown_where_there_is_room() -> None:
    async with front(NORMAL, StandingClock()) as it:
        for width, height in ((160, 48), (120, 36), (80, 24), (50, 15)):
            shown = await it.resize(width, height)
            assert ("heard" in shown) is (width >= 120)
            assert "5.0" in shown or width < 80
