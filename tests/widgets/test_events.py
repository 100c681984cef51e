"""Events: level, search, full screen, and the command to copy."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event, EventLog
from archo_tui.screen.widgets.events_panel import event_lines, events_as_text
from archo_tui.text.goal import goal_line
from archo_tui.text.state import fault_text
from tests.support.console import FAST, console
from tests.support.states import STATES, plain_text


def test_a_line_feed_is_a_blank_in_a_row_and_in_a_file() -> None:
    event = Event(0.0, "INFO", "server", "Incoming request\na: 2 b: 3")
    ((line, _),) = event_lines(event, 80, ())
    assert line.endswith("Incoming request a: 2 b: 3")
    assert events_as_text([event]).count("\n") == 1


def test_another_type_is_named_in_the_row_and_in_the_battery_panel() -> None:
    other = "archo_interfaces/msg/BatteryStatus or std_msgs/msg/Float32"
    fault = f"battery_level is std_msgs/msg/String: expected {other}"
    row = Event(0.0, "WARN", "console", fault)
    ((line, _),) = event_lines(row, 78, (0,))
    assert line.endswith("battery_level is String: expected BatteryStatus or Float32")
    ((line, _),) = event_lines(row, 140, (0,))
    assert line.endswith(fault)  # with room for the packages
    assert fault_text(fault, 25) == "wrong type: String"
    wrong = STATES["battery of another type"]._replace(goal=None)
    said = plain_text(goal_line(wrong, 0.0, "", 76))
    assert said == "move_to_shelf is Fibonacci: expected MoveToShelf"
    assert fault_text("battery_level has several types: a, b", 60).endswith("a, b")


async def test_a_search_keeps_what_has_the_letters_and_levels_show_more() -> None:
    async with console(*FAST) as op:
        await op.press("r", "c")
        await op.until("reset encoder: Encoder reset to zero")
        await op.until("✓  charge")
        await op.press("6", "slash")
        await op.type("ENCODER")
        await op.until(lambda: "✓  charge" not in op.text)
        assert "reset encoder: Encoder reset to zero" in op.text
        await op.press("enter")
        assert op.app.focused is not None
        assert op.app.focused.id == "event-list"
        await op.press("slash", "escape")
        await op.until("✓  charge")

        await op.press("6", "slash", *"ENCODER", "enter")
        await op.until("6 Events   / ENCODER: 1 of 2")
        await op.press("4", "escape")  # of another panel
        await op.until("6 Events   / ENCODER: 1 of 2")
        await op.press("6", "escape")
        await op.until("✓  charge")
        assert "ENCODER:" not in op.text
        await op.press("l", "l", "l")
        await op.until("6 Events   ERROR and above")
        await op.press("l")
        await op.until(lambda: "6 Events   ERROR" not in op.text)

        assert "Dashboard sees" not in op.text
        await op.press("6", "l")
        await op.until("Dashboard sees: ")
        await op.until("INFO and above")

        await op.press("6", "e")
        await op.until(lambda: "1 Battery" not in op.text)
        await op.press("slash", *"x", "escape")
        await op.settle()
        assert "1 Battery" not in op.text  # the search first
        await op.press("escape")
        await op.until("1 Battery")
        assert op.focused_panel == 6


async def test_page_keys_move_by_pages() -> None:
    async with console(*FAST) as op:
        for number in range(60):
            op.app.station.robot.note("YOU", "console", f"line {'x' * number}")
        await op.until(f"line {'x' * 59}")
        await op.press("6")
        events, places = op.app.main.events, []
        height = events.focus_target.size.height
        assert height > 4
        for key in ("pagedown", "pagedown", "pageup", "end", "pageup", "home"):
            await op.press(key)
            places.append(events.rows.cursor)
        page, last = height - 1, len(events.shown) - 1
        assert places == [page, 2 * page, page, last, last - page, 0]
        await op.press("pagedown")
        assert events.selected is not None
        assert events.selected.text in op.text


async def test_y_copies_and_ctrl_s_saves_the_commands_of_events(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    async with console(*FAST) as op:
        await op.press("6", "y")
        await op.until("no event is selected")
        op.app.station.robot.note("WARN", "console", "only text")
        await op.until("only text")
        await op.press("y")
        await op.until("this event has no command")
        assert op.app.clipboard == "only text"
        await op.press("r")
        await op.until("reset encoder: Encoder reset to zero")
        await op.press("c")
        await op.until("✓  charge")
        await op.press("down", "y")
        wanted = "ros2 service call /reset_encoder archo_interfaces/srv/ResetEncoder '{}'"
        await op.until(lambda: op.app.clipboard == wanted)
        await op.press("home", "y")
        await op.until(lambda: "/set_charging std_srvs/srv/SetBool" in op.app.clipboard)

        await op.press("6", "slash", *"reset", "enter", "ctrl+s", "enter")
        await op.until("Saved to events.txt")
    (line,) = (tmp_path / "events.txt").read_text().splitlines()
    assert "YOU    console  reset encoder: Encoder reset to zero   $ ros2 service call" in line
    datetime.fromisoformat(line.partition("  ")[0])


async def test_in_a_small_terminal_an_event_a_search_and_the_full_screen_have_room() -> None:
    async with console(*FAST, size=(80, 24)) as op:
        await op.press("r")
        await op.until("reset encoder: Encoder reset to zero")
        await op.press("6", "enter")
        await op.until("reset encoder: Encoder reset to zero")
        assert "$ ros2 service call /reset_encoder archo_interfaces/srv/ResetEncoder" in op.text
        await op.press("escape")
        await op.until(lambda: op.app.screen is op.app.main)

        before = op.app.main.parameters.size.height
        await op.press("6", "slash", *"encoder")
        await op.until("1 of ")
        assert "reset encoder: Encoder reset to zero" in op.text
        await op.press("escape")
        await op.until(lambda: "1 of " not in op.text)
        assert op.app.main.parameters.size.height == before

        await op.press("6", "e", "4")
        await op.until("4 Parameters")
        assert op.focused_panel == 4


async def test_the_cursor_stays_with_its_event_while_others_come() -> None:
    async with console(*FAST) as op:
        await op.press("r")
        await op.until("reset encoder: Encoder reset to zero")
        await op.press("c")
        await op.until("↯ CHARGING")
        await op.press("6", "down")
        before = op.app.main.events.selected
        await op.press("c")
        await op.until("discharge: Not charging")
        assert op.app.main.events.selected == before


@pytest.mark.parametrize(
    ("level", "code", "glyph"),
    [
        ("WARN", None, "▲"),
        ("ERROR", None, "✗"),
        ("INFO", None, "·"),
        ("YOU", Code.DONE, "✓"),
        ("YOU", Code.ACCEPTED, "·"),
        ("YOU", Code.REFUSED, "✗"),
        ("SHELL", Code.TIMEOUT, "▲"),
        ("GOAL", Code.ARRIVED, "✓"),
        ("GOAL", Code.ABORTED, "✗"),
    ],
)
def test_a_glyph_tells_how_an_event_ended(level: str, code: Code | None, glyph: str) -> None:
    record = None if code is None else AuditRecord("go", {}, code)
    event = EventLog().add(Event(0.0, level, "console", "text", audit_record=record))
    ((line, _),) = event_lines(event, 80, ())
    assert line.endswith(f"  {glyph}  text")


def test_the_source_of_an_event_stands_before_it_unless_that_is_the_console() -> None:
    ((line, _),) = event_lines(Event(0.0, "PEER", "anna_lab", "STOP: confirmed"), 80, ())
    assert line.endswith("·  anna_lab: STOP: confirmed")
    ((line, _),) = event_lines(Event(0.0, "WARN", "dashboard", "low"), 60, ())
    assert line.endswith("▲ low")
