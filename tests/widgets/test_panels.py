"""Panels 3, 6 and 8: a queue of targets and its bar, events by level and search, the graph."""

from __future__ import annotations

import re
from datetime import datetime
from pathlib import Path

import pytest

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event, EventLog
from archo_tui.robot.state.goal import Phase
from archo_tui.screen.widgets.events_panel import event_lines, events_as_text
from archo_tui.text.goal import goal_line, goal_strip, remaining_text
from archo_tui.text.state import fault_text
from tests.support import clock
from tests.support.clock import seconds
from tests.support.console import BRISK, FAST, LONG, Console, console
from tests.support.front import front
from tests.support.states import ARRIVED, MOVING, NORMAL, STATES, plain_text
from tests.support.stub import StandingClock


def history(op: Console) -> list[str]:
    """The targets that were driven, the oldest first."""
    return [f"{goal.target} {goal.word}" for goal in reversed(op.app.view.snapshot.history)]


async def test_several_targets_are_driven_in_turn_and_a_mistake_stays_said() -> None:
    async with console(*BRISK) as op:
        await op.press("g", *"12 7 3", "enter")
        await op.until("MOVING to 12")
        assert "then 7, 3" in op.text
        await op.until("MOVING to 7")
        assert "then 3" in op.text
        await op.until(lambda: len(op.app.view.snapshot.history) == 3)
        assert history(op) == ["12 ARRIVED", "7 ARRIVED", "3 ARRIVED"]
        assert not op.app.view.waiting

        await op.press("escape", "escape")
        await op.press("g", *"12 7", "enter")
        await op.until("MOVING to 12")
        await op.press("x", "enter")
        await op.until("Shelf: not a whole number: x")
        await op.until("MOVING to 7")
        await op.settle()
        assert "Shelf: not a whole number: x" in op.text


async def test_a_double_enter_sends_once_a_form_waits_and_a_cancel_holds_the_rest() -> None:
    async with console(*LONG) as op:
        await op.press("g", "5", "enter", "enter")
        await op.until("MOVING to 5")
        await op.press("6", "enter", "enter", "enter")
        await op.until("then 6")
        await op.settle()
        assert op.app.view.waiting == ("6",)

        await op.press("escape", "G", *"shelf", "enter")
        await op.until("Shelf ")  # the form of the robot file
        await op.press("7", "enter")
        await op.settle()  # not with the next second only
        assert "then 6, 7" in op.text

        await op.press("ctrl+c")
        await op.until("held: 6, 7 (cancelled)   n continue   k skip")
        await op.settle()
        assert history(op) == ["5 CANCELLED"]


async def test_a_refused_target_holds_the_rest_until_it_is_continued(unlimited: Path) -> None:
    async with console(*FAST, robot=unlimited) as op:
        await op.press("g", *"12 99 7 3", "enter")
        await op.until("held: 7, 3 (refused)")
        assert re.search(r"✗ REFUSED      at \d\d:\d\d:\d\d: shelf 99 is not in 1 .. 40", op.text)
        assert history(op) == ["12 ARRIVED", "99 REFUSED"]
        await op.until("queue held: 7, 3 (refused)")
        await op.at(seconds() + 3.0)
        (noted,) = (e for e in op.app.view.snapshot.events if e.text.startswith("queue held"))
        assert noted.count == 1
        await op.press("escape", "k")
        await op.until("held: 3 (refused)")
        await op.press("n")
        await op.until("MOVING to 3")
        await op.until(lambda: history(op)[-1] == "3 ARRIVED")
        await op.until(lambda: "✗ 99 refused" in op.line("last goals:"))


async def test_nothing_is_sent_behind_a_stop_and_its_release_continues_nothing() -> None:
    async with console(*LONG) as op:
        op.send("g", *"12", "enter", *"7")  # what is typed behind enter is the next target
        await op.until("m left of")
        assert op.app.main.goal.fields[0].value == "7"
        await op.press("enter")
        await op.until("then 7")
        await op.press("ctrl+x")
        await op.until("✗ STOPPED")
        await op.until("held: 7 (STOP)")
        await op.press("escape", "n")
        await op.until("continue the queue: still held: STOP")
        assert op.app.view.waiting == ("7",)
        await op.press("R", "y")
        await op.until("● IDLE")
        await op.settle()
        assert history(op) == ["12 ABORTED"]
        assert op.app.view.waiting == ("7",)
        await op.press("n")
        await op.until("MOVING to 7")


async def test_a_wrong_target_sends_none_and_the_arrows_recall_what_was_sent() -> None:
    async with console(*FAST) as op:
        await op.press("n")
        await op.until("no queue is held")
        await op.press("k")
        await op.until("no goal waits in the queue")

        await op.press("ctrl+u", "escape")
        await op.press("g", *"12 99999999999 3", "enter")
        await op.until("Shelf: at most")
        await op.settle()
        assert op.app.view.snapshot.goal is None
        assert not op.app.view.waiting

        await op.press("ctrl+u")
        for text in ("12", "7 3"):
            await op.press("g", *text, "enter")
            await op.until(lambda: not op.app.view.waiting)
        await op.type("4")
        field = op.app.main.goal.fields[0]
        seen = []
        for key in ("up", "up", "up", "down", "down"):
            await op.press(key)
            seen.append(field.value)
        assert seen == ["7 3", "12", "12", "7 3", "4"]


DRIVING = STATES["motor moving"]


def rows(goal: object, width: int = 56) -> list[str]:
    return [plain_text(line).rstrip() for line in goal_strip(goal, width, 3)]  # type: ignore[arg-type]


def test_the_way_driven_is_a_thick_bar_up_to_the_robot() -> None:
    above, line, below = rows(MOVING, 20)
    assert (above, line, below) == ("▄▄▄▄▄▄", "██████▶─────   50 %", "▀▀▀▀▀▀")
    assert rows(ARRIVED, 20)[1] == "███████████▶  100 %"


def test_no_number_moves_as_the_robot_does() -> None:
    far, near = MOVING._replace(length=100.0, remaining=100.0), MOVING._replace(length=100.0)
    first, then = rows(far, 100)[1], rows(near, 100)[1]
    assert first.index(" m ") == then.index(" m ")
    assert first.index("%") == then.index("%")


def test_a_robot_just_behind_its_goal_has_nothing_left() -> None:
    assert remaining_text(MOVING._replace(remaining=-0.04)) == "0.0 m left"


SENT, UNREADABLE = MOVING._replace(phase=Phase.SENT), MOVING._replace(unreadable="nan")


@pytest.mark.parametrize("goal", [None, SENT._replace(remaining=None), UNREADABLE])
def test_a_way_that_is_not_known_has_no_robot_on_it(goal: object) -> None:
    assert rows(goal, 20) == ["", "────────────     --", ""]


SIZES = [((120, 29), 6), ((120, 44), 8), ((80, 36), 6), ((200, 60), 8), ((79, 60), 6)]


async def test_bar_history_and_graph_take_the_room_there_is() -> None:
    async with front(DRIVING, StandingClock(), size=(120, 24)) as it:
        for (width, height), rows_of_goal in SIZES:
            await it.resize(width, height)
            assert it.main.goal.region.height == rows_of_goal, (width, height)
            shown = await it.tick()
            assert ("█▶" in shown) is (rows_of_goal == 8)
            assert len(re.findall("50 %", shown)) == 1
            assert shown.count("about 1.5 s left") == 1
            if width >= 120 and height >= 44:
                for words in ("7 History", "8 Graph", "remaining 9.0 m", "max_speed"):
                    assert words in shown, words
                assert it.main.events.region.height >= 8
        await it.resize(50, 15)
        assert it.main.goal.region.height == 6


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


async def test_it_shows_types_and_who_publishes_or_serves_them() -> None:
    from std_msgs.msg import Float32

    async with console(*FAST) as op:
        await op.press("8")
        await op.until("8 Graph")
        found = [
            line[1:-1].split() for line in op.text.splitlines() if re.search("/(msg|srv)/", line)
        ]
        level = ["topic", "/battery_level", "archo_interfaces/msg/BatteryStatus", "battery_monitor"]
        assert any(row[:4] == level for row in found)
        assert ["service", "/set_charging", "std_srvs/srv/SetBool", "battery_monitor"] in found
        action = "/move_to_shelf archo_interfaces/action/MoveToShelf motor_controller"
        await op.until(lambda: action in op.words)
        assert "no publisher" in op.line("/battery_drain")
        for own in ("/rosout", "/parameter_events", "get_parameters", "_archo_console"):
            assert own not in op.text

        await op.press("escape")
        await op.press("8")
        await op.until(lambda: "no publisher" in op.line("/battery_drain"))
        await op.at(clock.seconds() + 3)  # nothing else comes any more
        node = op.session.host.nodes[2].node
        node.create_publisher(Float32, "battery_drain", 10)
        await op.until(lambda: "motor_controller" in op.line("/battery_drain"))


async def test_the_rate_of_what_the_console_hears_is_there_and_its_silence() -> None:
    async with console() as op:
        await op.press("8")
        await op.until(lambda: op.line("/battery_level").rstrip("┃ ").endswith("1.0 Hz"))
        await op.until(lambda: op.line("/motor_status").rstrip("┃ ").endswith("5.0 Hz"))
        await op.press("escape", "5", "home", "s")
        await op.until("○ battery_monitor")
        await op.press("8")
        await op.until(lambda: "no publisher" in op.line("/battery_level"))
        await op.until(lambda: "silent" in op.line("/battery_level"))
        assert "/set_charging" not in op.text
        await op.press("escape", "5", "home", "s", "8")
        await op.until(lambda: "battery_monitor" in op.line("/set_charging"))
        await op.until(lambda: "Hz" in op.line("/battery_level"))


async def test_enter_shows_all_that_is_known_of_one() -> None:
    async with front() as it:
        text = await it.write("8", "down", "enter")
        assert "archo_interfaces/msg/BatteryStatus" in text
        assert "from /battery_monitor" in text
        assert "served by     /motor_controller" in await it.write("escape", "end", "enter")


async def test_where_it_has_no_room_8_opens_it_and_escape_goes_back() -> None:
    async with front(size=(80, 24)) as it:
        for width, height in ((80, 24), (120, 36), (200, 24)):
            await it.resize(width, height)
            await it.press("5")
            assert not it.main.graph.display
            await it.press("8")
            assert it.main.graph.size.width > width - 6
            assert not it.main.nodes.region
            await it.press("escape")
            assert not it.main.graph.display
            assert it.focused_panel == 5
        # its focus and full screen outlast every size
        await it.resize(160, 48)
        await it.press("8")
        await it.resize(149, 43)  # there is no room any more
        assert it.focused_panel == 4
        await it.press("8")
        await it.resize(150, 48)
        assert it.main.is_full
        assert it.focused_panel == 8
        await it.press("escape")
        assert it.focused_panel == 8
        assert it.main.nodes.region
        for width, height in ((1, 1), (160, 30)):
            await it.resize(width, height)
        assert it.main.graph.region.height >= 5


async def test_panels_cost_nothing_while_nothing_in_them_changes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hidden = NORMAL.parameters[0]._replace(name="use_sim_time", value=False, initial=False)
    before = NORMAL._replace(parameters=(*NORMAL.parameters, hidden))
    clock, drawn = StandingClock(), list[str]()
    async with front(before, clock, size=(160, 48)) as it:
        await it.press("8")
        for panel in (it.main.graph.focus_target, it.main.parameters):
            name = str(panel.id)
            note = lambda *_, name=name, **__: drawn.append(name)  # noqa: E731
            monkeypatch.setattr(panel, "refresh", note)
        for second in range(3):
            clock.passed += 1.0
            rates = {
                name: rate._replace(heard=rate.heard + second)
                for name, rate in NORMAL.message_rates.items()
            }
            it.robot.put(before._replace(message_rates=rates))
            await it.tick()
        assert drawn == []
        it.robot.put(NORMAL._replace(resources=NORMAL.resources[1:]))
        it.app.tick()
        assert len({*drawn}) == 2


async def test_the_lists_get_what_they_need_and_the_events_the_rest() -> None:
    async with front(size=(200, 60)) as it:
        main = it.main
        for width, height in ((150, 30), (200, 60)):
            await it.resize(width, height)
            assert main.nodes.region.height == 7  # three nodes, at least five rows
            upper = main.goal.region.height + main.parameters.region.height
            assert upper == (17 if height <= 40 else main.goal.region.height + 7)
            assert main.graph.region.bottom == main.history.region.bottom or height <= 40
            if height > 40:  # The history has a row of its own, and events at most a quarter.
                assert main.history.region.height >= 17
                assert 8 <= main.events.region.height <= height // 4
                assert main.events.region.width == width
            assert main.events.region.width >= 60
            assert main.events.region.bottom == height - 1
        for size, rows in (((80, 24), 5), ((80, 30), 9), ((120, 36), 15)):
            await it.resize(*size)
            assert main.events.region.height == rows  # three and more, with the border
            assert main.parameters.region.height >= 5  # both that are shown
        await it.resize(300, 80)
        nodes = tuple(NORMAL.nodes[0]._replace(name=f"/node_{n}") for n in range(40))
        many = tuple(NORMAL.parameters[0]._replace(name=f"gain_{n}") for n in range(20))
        await it.put(NORMAL._replace(nodes=nodes, parameters=many))
        assert main.nodes.region.height == 14
        height = main.parameters.region.height
        await it.write("4", "slash", *"gain_7")  # moves nothing
        assert len(main.parameters.rows.items) == 1
        assert main.parameters.region.height == height
