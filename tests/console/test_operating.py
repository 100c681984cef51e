"""An operator at the keyboard: what is seen at the start, goals, encoder, STOP, charging."""

from __future__ import annotations

import json
import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import pytest
from archo_bringup.motor_controller import MotorController
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.parameter import Parameter
from textual.widgets import Input

from archo_tui.base.paths import journal_file
from archo_tui.robot.state.events import LIMIT
from archo_tui.screen.keyed_app import HELD
from archo_tui.screen.widgets.bars import header
from archo_tui.screen.widgets.battery_panel import BatteryPanel
from archo_tui.screen.widgets.field import Field
from archo_tui.session.session import _robots_nodes
from tests.support.clock import seconds, stuck
from tests.support.console import BRISK, FAST, LONG, PANEL_KEYS, Console, console
from tests.support.front import Front, front, reset_main
from tests.support.night import corners
from tests.support.states import NORMAL
from tests.support.stub import StandingClock, stub_app


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


async def test_a_goal_is_typed_driven_and_arrives() -> None:
    async with console(*FAST) as op:
        await op.press("g")
        await op.type("12")
        await op.press("enter")
        await op.until("✓ ARRIVED      Arrived at shelf 12, 18.0 m in ")
        assert "100 %" in op.text
        await op.until("last goals: ✓ 12 arrived")
        assert "go to shelf 12: accepted" in op.text
        sent = next(event for event in op.app.view.snapshot.events if "accepted" in event.text)
        assert sent.command.startswith("ros2 action send_goal /move_to_shelf")
    kept = [json.loads(line) for line in journal_file().read_text().splitlines()]
    assert [e["text"] for e in kept if e["kind"] == "goal"] == ["Arrived at shelf 12"]


async def test_the_way_left_is_shown_and_ctrl_c_or_the_button_cancels() -> None:
    async with console(*LONG) as op:
        await op.press("g", "1", "2", "enter")
        await op.until(lambda: re.search(r"MOVING to 12   9\d\d\.\d m left of 1000\.0 m", op.text))
        await op.until(lambda: re.search(r"so far, about \d+\.?\d* \w+ left", op.text))
        assert "MOVING to 12" in op.text.splitlines()[0]
        await op.until("▶ MOVING")
        await op.type("7")
        await op.press("ctrl+c")
        await op.until("✗ CANCELLED    Cancelled mid-route, ")
        assert op.app.query_one("#goal-0", Input).value == "7"
        await op.until("cancel: accepted")
        events = op.app.view.snapshot.events
        (command,) = (e.command for e in events if e.text == "cancel: accepted")
        assert command.startswith("ros2 service call /move_to_shelf/_action/cancel_goal")
        assert op.app.view.snapshot.goal is not None
        remaining = op.app.view.snapshot.goal.remaining
        assert remaining is not None
        assert 0 < remaining < 1000
        await op.until("● IDLE")

        await op.press("ctrl+u", "escape")
        await op.press("g", "5", "enter")
        await op.until("MOVING to 5")
        await op.pilot.click("#cancel")
        await op.until("✗ CANCELLED")


async def test_what_is_no_shelf_is_said_and_sends_nothing() -> None:
    async with console(*FAST) as op:
        await op.press("g")
        for typed, said in (
            ("abc", "Shelf: not a whole number: abc"),
            ("0", "Shelf: at least 1, not 0"),
            ("41", "Shelf: at most 40, not 41"),
            ("٣", "Shelf: not a whole number: ٣"),
        ):
            op.app.query_one("#goal-0", Input).value = typed
            await op.press("enter")
            await op.until(said)
        assert "No goal yet." in op.text
        assert op.app.view.snapshot.goal is None

        await op.press("ctrl+u")
        await op.press("g")
        op.app.query_one("#goal-0", Input).insert_text_at_cursor("9" * 10_000)
        await op.press("enter")
        await op.until("Shelf: at most 40, not 999")
        assert op.app.view.snapshot.goal is None

        for typed in ("1ox5", "o15", "1r", "1rcq", "12s", "0x10", "15a", "1_2"):
            await op.press("g", "ctrl+u")
            op.send(*typed, "enter")
            await op.until(f"Shelf: not a whole number: {typed}")
            assert op.app.query_one("#goal-0", Input).value == typed
            await op.press("backspace", "r")  # what was refused can be mended, and is still text
            assert op.app.query_one("#goal-0", Input).value == f"{typed[:-1]}r"
            assert op.app.screen is op.app.main
            assert op.app.view.snapshot.goal is None
            assert not [event for event in op.app.view.snapshot.events if event.level == "YOU"]
            await op.at(seconds() + 1.0)

        await op.press("ctrl+u")
        await op.press("g", "1", "r", "backspace", "backspace", "c")
        await op.until("✓  charge")
        assert op.app.query_one("#goal-0", Input).value == ""

        await op.press("ctrl+u")
        await op.press("ctrl+c")
        await op.until("Press q (or")
        assert op.app.is_running

        await op.press("ctrl+u")
        await op.press("g", "5")
        await op.pilot.click("#go")
        await op.until("Arrived at shelf 5")


async def test_a_red_hint_leaves_with_the_next_key() -> None:
    async with console(*LONG) as op:
        await op.press("g", "ctrl+x")
        await op.until("✗ STOPPED")
        await op.press("7", "enter")
        await op.until("emergency stop: release it first")
        await op.press("escape")
        await op.until(lambda: "release it first" not in op.line("Shelf"))
        await op.press("R", "y")
        await op.until("● IDLE")
        await op.press("g", *"45", "enter")
        await op.until("Shelf: at most 40")
        await op.press("left")
        await op.until(lambda: "at most 40" not in op.text)


async def test_a_held_ctrl_c_cancels_once_and_then_says_nothing() -> None:
    async with console(*LONG) as op:
        await op.press("g", "1", "2", "enter")
        await op.until("m left of")
        begin = seconds()
        for number in range(60):  # as a keyboard repeats
            await op.at(begin + 0.03 * number)
            op.send("ctrl+c")
        await op.until("✗ CANCELLED")
        assert "No goal is running" not in op.text
        said = [event.text for event in op.app.view.snapshot.events if event.level == "YOU"]
        assert said.count("cancel: accepted") == len(said) - 1 == 1  # and that it was sent


async def test_the_form_of_a_goal_shows_its_range_and_offers_no_value_beyond() -> None:
    async with console(*BRISK) as op:
        await op.press("G", *"move", "enter")
        await op.until("esc cancel")
        assert "int32, 1 .. 40" in op.line("┃ Shelf")
        assert "0 int32" not in op.words
        await op.press("enter")
        await op.until("Shelf: type a value")
        await op.press(*"12", "enter")
        await op.until("MOVING to 12")


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


@contextmanager
def flooding(op: Console, rate: float, publish: Callable[[int], None]) -> Iterator[list[int]]:
    """Call `publish` that often (Hz), or as often as the machine can, from a thread."""
    ending, sent = threading.Event(), [0]

    def run() -> None:
        began = time.monotonic()
        while not ending.is_set():
            due = int((time.monotonic() - began) * rate)
            for _ in range(min(due - sent[0], 100)):
                publish(sent[0])
                sent[0] += 1
            ending.wait(0.001)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield sent
    finally:
        ending.set()
        thread.join(10)


# On a busy machine this takes long, and an empty battery would refuse the move.
FULL = ("-p", "drain_min:=0.0", "-p", "drain_max:=0.0")


@pytest.mark.real_time  # the flood comes from a thread of its own
async def test_keys_answer_beside_ten_thousand_log_lines_a_second() -> None:
    async with console(*FAST, *FULL) as op:
        talker = Node("talker", context=op.session.context)
        publisher = talker.create_publisher(Log, "/rosout", 1000)

        def publish(number: int) -> None:
            text = f"{'abcdefghijk'[number % 11] * 5} \x1b[31m\u202e{number}"
            publisher.publish(Log(level=Log.WARN, name="talker", msg=text))

        with flooding(op, 10_000, publish) as sent:
            await op.until(lambda: sent[0] > 5_000)
            op.send("r")
            said = "reset encoder: Encoder reset to zero"  # the list may show newer lines only
            await op.until(lambda: any(said == e.text for e in op.app.view.snapshot.events))
            op.send("g", "7", "enter")
            await op.until("Arrived at shelf 7")
            op.send("escape", "ctrl+x")
            await op.until(lambda: op.app.view.snapshot.motion.stopped)
        assert len(op.app.view.snapshot.events) <= LIMIT
        assert "\x1b" not in op.text
        assert "\u202e" not in op.text
        assert "�[31m" in op.text
        talker.destroy_node()
