"""What somebody sees who starts the console for the first time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from archo_bringup.motor_controller import MotorController
from rclpy.node import Node
from rclpy.parameter import Parameter
from textual.app import App

from archo_tui.screen.widgets.bars import header
from tests.support.console import FAST, click, console, focused_panel, screen_text, send
from tests.support.quiet import Quiet
from tests.support.states import NORMAL, STATES
from tests.support.stub import stub_app


def bars(app: App[Any]) -> list[str]:
    """The rows that have the cursor's bar."""
    found = []
    for strip in app.screen._compositor.render_strips():
        shown = [one.text for one in strip if one.style is not None and one.style.reverse]
        found += [text.strip() for text in shown if "╎" not in text]
    return [text for text in found if text]


async def test_parameters_that_nobody_changes_are_hidden_until_they_are_asked_for() -> None:
    async with console(*FAST) as op:
        await op.press("full_stop")
        before = op.app.view.snapshot.parameters
        await op.press("space")
        await op.until("no parameter is selected")
        assert op.app.view.snapshot.parameters == before

        await op.press("full_stop")
        await op.until(". shows 16 more")
        assert op.parameters == ["low_battery_threshold", "max_speed"]
        await op.press("4", "full_stop")
        await op.until(". hides 16 more")
        assert op.text.count("use_sim_time") == 3
        assert op.text.count("start_type") == 3
        assert len(op.parameters) == 18
        await op.press("full_stop")
        await op.until("shows 16 more")
        assert op.parameters == ["low_battery_threshold", "max_speed"]

        await op.press("escape")
        await op.press("4", "slash", *"sim")
        await op.until("use_sim_time")
        await op.until(lambda: "shows" not in op.text)


async def test_of_a_node_that_the_robot_file_does_not_know_all_parameters_are_shown() -> None:
    class Gripper(Node):
        def __init__(self, **options: Any) -> None:
            super().__init__("gripper", **options)
            self.declare_parameter("force", 0.5)

    async with console(*FAST, node_makers=[Gripper, MotorController], wait=False) as op:
        await op.until(lambda: op.parameters == ["force", "max_speed"])


async def test_overrides_of_qos_are_parameters_of_every_ros_node_too() -> None:
    async with console(*FAST) as op:
        node = op.session.host.nodes[1].node
        node.declare_parameter("qos_overrides./battery_level.subscription.depth", 10)
        await op.until(". shows 17 more")
        assert "qos_overrides" not in op.text


async def test_what_is_hidden_costs_nothing_while_it_stays_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = NORMAL.parameters[0]._replace(name="use_sim_time", value=False, initial=False)
    snapshot = NORMAL._replace(parameters=(*NORMAL.parameters, own))
    app = stub_app(snapshot)
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        assert "shows 4 more" in screen_text(app)
        drawn: list[object] = []
        monkeypatch.setattr(app.main.parameters, "refresh", lambda *_, **__: drawn.append(1))
        app._on_snapshot(snapshot)
        app.tick()
        await quiet.settle()
        assert drawn == []
        app._on_snapshot(NORMAL)
        assert drawn


async def test_a_hidden_parameter_that_was_changed_is_shown() -> None:
    async with console(*FAST) as op:
        await op.until("shows 16 more")
        node = op.session.host.nodes[1].node
        node.set_parameters([Parameter("use_sim_time", value=True)])
        await op.until("true *")
        assert "use_sim_time" in op.line("true *")
        await op.until("shows 15 more")


async def test_no_list_has_a_bar_before_somebody_comes_and_the_header_says_what_counts() -> None:
    app = stub_app(STATES["normal"])
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        assert focused_panel(app) == 4
        assert bars(app) == []
        send(app, "down")  # shows which one is meant, and the next one moves
        await quiet.settle()
        assert "low_battery_threshold" in bars(app)[0]
        send(app, "down")
        await quiet.settle()
        assert "max_speed" in bars(app)[0]
        for key, first in (("5", "battery_monitor"), ("6", "Low battery"), ("4", "max_speed")):
            send(app, key)
            await quiet.settle()
            assert first in bars(app)[0]

        await Quiet(app).settle()
        assert header(app.view, 80).plain.endswith(" embedded ")
        assert header(replace(app.view, namespace="/left"), 80).plain.endswith(" /left ")

        await Quiet(app).settle()
        view = replace(app.view, replay="REPLAY 2026-11-23 19:12:50")
        assert header(view, 80).plain.startswith(" REPLAY 2026-11-23 19:12:50   ARCHO   ● online ")
        for width in (11, 20, 31):
            assert header(view, width).plain.startswith(" REPLAY 20")


async def test_tab_and_a_click_bring_the_bar_too() -> None:
    for come in ("tab", "4", "click"):
        app = stub_app(STATES["normal"])
        async with app.run_test(size=(120, 36)):
            quiet = Quiet(app)
            await quiet.settle()
            if come == "click":
                rows = app.main.parameters.focus_target.region
                click(app, rows.x + 2, rows.y)
            else:
                send(app, come)
            await quiet.settle()
            assert len(bars(app)) in (1, 2), come  # one row, with its description
            assert len(app.screen_stack) == 1


async def test_all_panels_have_room_from_80_x_24_on() -> None:
    app = stub_app(NORMAL, size=(80, 24))
    async with app.run_test(size=(80, 24)) as pilot:
        for size in ((80, 24), (80, 30), (100, 30), (110, 24), (150, 30), (200, 60)):
            await pilot.resize_terminal(*size)
            await Quiet(app).settle()
            assert not app.main.query_one("#body").show_vertical_scrollbar, size
