"""What somebody sees who starts the console, where the focus is then, and what keys do there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from archo_bringup.motor_controller import MotorController
from rclpy.node import Node
from rclpy.parameter import Parameter

from archo_tui.screen.widgets.bars import header
from archo_tui.screen.widgets.field import Field
from tests.support.console import FAST, LONG, PANEL_KEYS, console
from tests.support.front import Front, front, reset_main
from tests.support.states import NORMAL
from tests.support.stub import StandingClock, stub_app


async def test_at_the_start_letters_are_commands_and_the_footer_shows_them() -> None:
    async with console(*LONG, in_field=True) as op:
        assert "enter Go" in op.text
        assert "esc Leave  ^c Cancel  ^x STOP  r Reset  ? Help  q Quit" in op.text
        assert f"{PANEL_KEYS} Panels" not in op.text
        await op.press("question_mark")
        assert "Here, in Go to shelf" in op.text
        await op.press("escape", "1")
        assert "q Quit" not in op.text.splitlines()[-1]  # It would be text behind the 1.
        await op.press("backspace")
        assert "q Quit" in op.text.splitlines()[-1]
        await op.press("ctrl+x")
        await op.until("STOPPED")


async def test_at_the_start_a_number_and_enter_drive_and_enter_alone_does_not() -> None:
    async with console(*FAST, in_field=True) as op:
        assert isinstance(op.app.focused, Field)
        await op.press("enter", "enter")
        assert op.app.view.snapshot.goal is None
        assert len(op.app.screen_stack) == 1
        await op.press("1", "2", "enter")
        await op.until("12 arrived")

        await op.press("escape")
        assert op.focused_panel == 4
        assert f"{PANEL_KEYS} Panels" in op.text
        await op.press("5")
        assert op.focused_panel == 5


async def test_a_field_out_of_sight_has_no_focus_and_typing_in_one_shows_it() -> None:
    async with front(NORMAL, StandingClock(), size=(50, 15), in_field=True) as it:
        assert not isinstance(it.app.focused, Field)
        assert it.focused_panel == 4
    async with front(NORMAL, StandingClock(), in_field=True) as it:
        assert "Go to shelf" not in await it.resize(50, 12)
        shown = await it.press("7")
        assert "Shelf 7" in shown
        assert "STOP" in shown


def test_a_form_that_takes_text_does_not_have_the_focus_at_the_start() -> None:
    """In such a field no letter would be a command."""
    panel = stub_app(NORMAL).main.goal
    assert panel.first_field is panel.fields[0]
    panel.fields[0]._takes = ""
    assert panel.first_field is None


def bars(it: Front) -> list[str]:
    """The rows that have the cursor's bar."""
    found = []
    for strip in it.strips:
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


async def test_qos_overrides_are_hidden_and_a_changed_parameter_is_shown() -> None:
    async with console(*FAST) as op:
        node = op.session.host.nodes[1].node
        node.declare_parameter("qos_overrides./battery_level.subscription.depth", 10)
        await op.until(". shows 17 more")
        assert "qos_overrides" not in op.text
        node.set_parameters([Parameter("use_sim_time", value=True)])
        await op.until("true *")
        assert "use_sim_time" in op.line("true *")
        await op.until("shows 16 more")


async def test_no_list_has_a_bar_before_somebody_comes_by_a_key_or_a_click() -> None:
    async with front() as it:
        assert it.focused_panel == 4
        assert bars(it) == []
        await it.press("down")  # shows which one is meant, and the next one moves
        assert "low_battery_threshold" in bars(it)[0]
        await it.press("down")
        assert "max_speed" in bars(it)[0]
        for key, first in (("5", "battery_monitor"), ("6", "Low battery"), ("4", "max_speed")):
            await it.press(key)
            assert first in bars(it)[0]
        for come in ("tab", "click"):
            reset_main(it.main)
            await it.settle()
            assert bars(it) == []
            rows = it.main.parameters.focus_target.region
            await (it.press("tab") if come == "tab" else it.click(rows.x + 2, rows.y))
            assert len(bars(it)) in (1, 2), come  # one row, with its description
            assert len(it.app.screen_stack) == 1


async def test_the_header_says_what_counts_and_all_panels_have_room() -> None:
    async with front(size=(80, 24)) as it:
        for size in ((80, 24), (80, 30), (100, 30), (110, 24), (150, 30), (200, 60)):
            await it.resize(*size)
            assert not it.main.query_one("#body").show_vertical_scrollbar, size
    view = it.app.view
    assert header(view, 80).plain.endswith(" embedded ")
    assert header(replace(view, namespace="/left"), 80).plain.endswith(" /left ")
    view = replace(view, replay="REPLAY 2026-11-23 19:12:50")
    assert header(view, 80).plain.startswith(" REPLAY 2026-11-23 19:12:50   ARCHO   ● online ")
    for width in (11, 20, 31):
        assert header(view, width).plain.startswith(" REPLAY 20")
