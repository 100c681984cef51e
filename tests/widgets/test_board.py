"""The board of the shelves: what stands on it, and that choosing a shelf only types it."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy.node import Node
from textual import events
from textual.geometry import Region

from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.state.goal import Phase
from archo_tui.robot_file.model import GoalKind
from archo_tui.words.board import Mark, fit_grid, marks, selectable_numbers
from archo_tui.words.state import BAD, PLAIN, STRONG
from tests.support.archo import SHELF
from tests.support.clock import seconds
from tests.support.console import BRISK, FAST, LONG, Console, click, console
from tests.support.quiet import Quiet
from tests.support.states import ARRIVED, CANCELLED, NORMAL, ended, goal
from tests.support.states import board as with_shelves
from tests.support.stub import StubRobot, stub_app

TALL = (120, 44)


def first_line(op: Console) -> str:
    """The board's line with the first shelves, or an empty string."""
    return op.line("  8   9")


def typed(op: Console) -> str:
    return op.app.main.goal.fields[0].value


def sent(op: Console) -> list[str]:
    return [e.text for e in op.app.view.snapshot.events if e.text.startswith("go to shelf")]


async def test_where_it_goes_what_waits_and_how_it_ended_stand_at_the_shelves() -> None:
    async with console(*BRISK, size=TALL) as op:
        await op.press("g", *"12 7 3", "enter")
        await op.until("▶12")
        assert " 3²" in first_line(op)
        assert " 7¹" in first_line(op)
        await op.until("▶7")
        assert "12✓" in op.text
        assert " 3¹" in first_line(op)
        await op.press("ctrl+c")
        await op.until(" 7✗")
        await op.until("held: 3")
        assert " 3¹" in first_line(op)
        assert "▶7" not in op.text


@pytest.mark.parametrize("size", [TALL, (80, 24)])
async def test_enter_types_the_shelf_into_the_field_and_sends_nothing(
    size: tuple[int, int],
) -> None:
    async with console(*FAST, size=size) as op:
        await op.press("g", "tab", "right", "down", "enter")
        assert typed(op) == "12 "
        await op.press("tab", "left", "enter")
        assert typed(op) == "12 11 "
        await op.at(seconds() + 2.0)
        assert sent(op) == []
        await op.press("enter")
        await op.until("Arrived at shelf 11")
        assert sent(op) == ["go to shelf 12: accepted", "go to shelf 11: accepted"]


async def test_a_click_types_the_shelf_and_only_go_sends_it() -> None:
    async with console(*FAST, size=TALL) as op:
        await op.press("g", "5")
        region = op.app.main.goal.board.region
        click(op.app, region.x + 4 * 6 + 1, region.y)
        await op.settle()
        assert typed(op) == "5 7 "
        click(op.app, region.right - 1, region.y)  # beside the shelves
        await op.settle()
        assert typed(op) == "5 7 "
        assert sent(op) == []
        await op.pilot.click("#go")
        await op.until("Arrived at shelf 7")


async def test_enter_that_is_held_on_the_board_sends_nothing() -> None:
    async with console(*FAST, size=TALL) as op:
        await op.press("g", "tab")
        op.send(*["enter"] * 5)
        await op.settle()
        assert typed(op) == "1 "
        await op.at(seconds() + 2.0)
        assert sent(op) == []


@pytest.mark.parametrize("size", [TALL, (80, 24)])
async def test_what_is_typed_behind_tab_in_one_write_goes_where_it_was_meant(
    size: tuple[int, int],
) -> None:
    async with console(*FAST, size=size) as op:
        for keys, left in (
            (["3", "tab", "enter", "7"], "1 7"),
            (["ctrl+u", "9", "tab", "right", "down", "enter"], "9 12 "),
            (["ctrl+u", "9", "tab", "escape", "4"], "94"),
            (["ctrl+u", "tab", "home", "end", "enter", "5"], "40 5"),
            (["ctrl+u", "9", "tab", "shift+tab", "6"], "96"),
        ):
            op.send(*keys)
            await op.settle()
            assert typed(op) == left, keys
        assert sent(op) == []
        op.send("ctrl+u", "8", "tab", "tab", "enter")  # on Go
        await op.until("Arrived at shelf 8")


async def test_stop_on_the_board_is_final_for_what_was_typed_before_it() -> None:
    async with console(*LONG, size=TALL) as op:
        op.send("3", "tab", "enter", *"12 7", "enter", "tab", "ctrl+x")
        await op.until("✗ STOPPED")
        await op.at(seconds() + 2.0)
        assert op.app.view.snapshot.running_goal is None
        await op.press("enter")
        assert op.app.view.snapshot.motion.stopped
        assert op.app.view.snapshot.running_goal is None


async def test_stop_stands_while_the_board_has_the_focus_in_a_small_terminal() -> None:
    async with console(*LONG, size=(80, 24)) as op:
        await op.press("g", *"12", "enter")
        await op.until("MOVING to 12")
        await op.press("tab", "down", "ctrl+x")
        await op.until("✗ STOPPED")
        assert first_line(op)


async def test_without_room_it_opens_by_tab_and_closes_again() -> None:
    async with console(*FAST, size=(80, 24)) as op:
        assert not first_line(op)
        await op.press("g")
        assert "tab board" in op.text
        await op.press("tab")
        assert first_line(op)
        assert "40" in op.text
        await op.press("escape")
        assert not first_line(op)
        assert op.app.focused is op.app.main.goal.fields[0]
        await op.press("tab", "4")
        assert not first_line(op)
        assert op.focused_panel == 4


async def test_escape_leads_out_of_the_board_and_the_field_however_one_came_there() -> None:
    async with console(*FAST, size=(80, 24)) as op:
        await op.press("6", "g", "tab", "g", "escape")
        assert op.focused_panel == 6
        await op.press("g", "tab", "escape", "escape")
        assert op.focused_panel == 6


async def test_a_board_that_vanishes_gives_the_focus_to_the_field() -> None:
    app = stub_app(with_shelves(40), size=TALL)
    async with app.run_test(size=TALL) as pilot:
        await pilot.pause()
        await pilot.press("g", "tab")
        assert app.focused is app.main.goal.board
        robot: StubRobot = app.station.robot  # type: ignore[assignment]
        robot.put(NORMAL)
        await pilot.press("7")
        assert app.main.goal.fields[0].value == "7"


async def test_in_a_tiny_terminal_the_whole_board_is_seen_when_it_opens() -> None:
    async with console(*FAST, size=(60, 20)) as op:
        await op.press("g", "tab")
        await op.until(lambda: first_line(op) and " 31  32 " in op.text)


async def test_letters_on_the_board_are_commands_as_on_a_list() -> None:
    async with console(*FAST, size=TALL) as op:
        await op.press("g", "tab", "r")
        await op.until("reset encoder: zero")
        await op.press("6")
        assert op.focused_panel == 6


ARROWS = [
    (["left"], 1),
    (["up"], 1),
    (["end", "right"], 40),
    (["end", "down"], 40),
    (["down", "down", "down", "down", "down"], 31),
    (["end", "left", "up"], 29),
    (["pagedown"], 40),
    (["end", "home"], 1),
]


async def test_the_arrows_stay_on_the_board() -> None:
    app = stub_app(with_shelves(40), size=TALL)
    async with app.run_test(size=TALL) as pilot:
        await pilot.pause()
        for keys, shelf in ARROWS:
            app._last_typed = 0.0  # no key is held
            await pilot.press("g", "ctrl+u", "tab", "home", *keys, "enter")
            assert app.main.goal.fields[0].value == f"{shelf} "


async def test_the_wheel_turns_the_pages() -> None:
    app = stub_app(with_shelves(500), size=TALL)
    async with app.run_test(size=TALL) as pilot:
        await pilot.pause()
        board = app.main.goal.board
        board.post_message(_wheel(events.MouseScrollDown))
        await pilot.press("g", "tab", "enter")
        assert app.main.goal.fields[0].value == "131 "
        board.post_message(_wheel(events.MouseScrollUp))
        await pilot.press("tab", "enter")
        assert app.main.goal.fields[0].value == "131 1 "


def _wheel(kind: Any) -> events.Event:
    event: events.Event = kind(None, 1, 1, 0, 0, 0, False, False, False)
    return event


async def test_the_board_follows_what_the_robot_says_of_its_shelves() -> None:
    async with console(*FAST, size=TALL) as op:
        assert (await op.session.robot.set_parameters(MOTOR, {"shelf_count": 12})).ok
        await op.until(lambda: " 13 " not in op.text)
        assert " 12 " in op.text
        await op.press("g", *"13", "enter")
        await op.until("Shelf: at most 12, not 13")
        assert (await op.session.robot.set_parameters(MOTOR, {"shelf_count": 13})).ok
        await op.until(" 13 ")
        await op.press("enter")
        await op.until("Arrived at shelf 13")


MOTOR = "/motor_controller"


async def test_a_form_in_a_dialog_is_held_to_what_the_robot_says_too() -> None:
    async with console(*FAST) as op:
        await op.press("G", *"shelf", "enter")
        await op.until("enter send")
        await op.press("end", "ctrl+u", *"41", "enter")
        await op.until("Shelf: at most 40, not 41")
        assert sent(op) == []


class Strange(Node):
    """Has a word in place of the number of its shelves."""

    def __init__(self, **options: Any) -> None:
        super().__init__("motor_controller", **options)
        self.declare_parameter("shelf_count", "many", ignore_override=True)


async def test_without_a_number_of_shelves_there_is_no_board() -> None:
    async with console(node_makers=[Strange], size=TALL, wait=False) as op:
        await op.until("many")
        await op.press("g", "tab")
        assert not first_line(op)
        assert op.app.focused is op.app.query_one("#go")


async def test_a_board_on_which_nothing_changes_is_not_drawn() -> None:
    moving = goal(Phase.MOVING)._replace(parameters=with_shelves(40).parameters)
    app = stub_app(moving, size=TALL)
    async with app.run_test(size=TALL):
        quiet = Quiet(app)
        await quiet.settle()
        robot: StubRobot = app.station.robot  # type: ignore[assignment]
        drawn: list[Region | None] = []  # None: all of it
        board = app.main.goal.board
        board.refresh = lambda *regions, **_: drawn.extend(regions or [None])  # type: ignore
        assert moving.goal is not None
        for left in (8.0, 7.0):
            robot.put(moving._replace(goal=moving.goal._replace(remaining=left)))
            await quiet.settle()
        assert drawn == []
        robot.put(moving._replace(goal=ARRIVED))
        await quiet.settle()
        assert drawn == [Region(0, 1, board.size.width, 1)]  # the line of shelf 12


def test_the_last_end_is_brighter_than_those_before() -> None:
    refused = ended(20, Phase.REFUSED, "no")
    snapshot = NORMAL._replace(goal=refused, history=(refused, ARRIVED, CANCELLED))
    assert marks(snapshot, SHELF, ()) == {
        20: Mark(behind="✗", tone=BAD),
        12: Mark(behind="✓", tone=PLAIN),
        3: Mark(behind="✗", tone=PLAIN),
    }


def test_only_goals_of_this_kind_with_a_known_shelf_stand_on_it() -> None:
    other = ARRIVED._replace(kind=GoalKind("x", "x", "x", "x/action/X"), fields={"n": 5})
    anothers = ARRIVED._replace(mine=False, fields={})
    assert marks(NORMAL._replace(history=(other, anothers)), SHELF, ()) == {}


def test_a_shelf_that_waits_twice_shows_its_first_place() -> None:
    queue = [QueuedGoal(SHELF, {"shelf_number": n}) for n in (12, 7, 7, *range(20, 30))]
    found = marks(goal(Phase.MOVING), SHELF, queue)
    assert found[12] == Mark("▶", "¹", STRONG)
    assert found[7] == Mark(behind="²", tone=PLAIN)
    assert found[25] == Mark(behind="⁹", tone=PLAIN)
    assert found[29] == Mark(behind="⁺", tone=PLAIN)


@pytest.mark.parametrize(
    ("count", "width", "rows", "expected"),
    [
        (40, 78, 16, (10, 4, 1)),
        (40, 100, 16, (20, 2, 1)),
        (40, 36, 16, (5, 8, 1)),
        (40, 10, 16, (2, 15, 2)),
        (7, 78, 16, (7, 1, 1)),
        (200, 58, 20, (10, 20, 1)),
        (201, 58, 40, (10, 20, 2)),
        (500, 78, 16, (10, 15, 4)),
        (9999, 78, 4, (10, 3, 334)),
    ],
)
def test_columns_come_by_tens_or_five_and_pages_beyond_two_hundred(
    count: int, width: int, rows: int, expected: tuple[int, int, int]
) -> None:
    found = fit_grid(range(1, count + 1), width, rows)
    assert (found.columns, found.rows, found.pages) == expected
    assert found.columns * found.cell_width <= width


@pytest.mark.parametrize("shelves", [None, "many", True, float("nan"), 0, 1e15])
def test_what_is_no_number_of_shelves_makes_no_board(shelves: Any) -> None:
    assert selectable_numbers(with_shelves(shelves), SHELF) is None


def test_shelves_are_counted_from_the_lowest_to_the_highest() -> None:
    assert selectable_numbers(with_shelves(40), SHELF) == range(1, 41)
    assert selectable_numbers(with_shelves(40)._replace(forms={}), SHELF) is None


async def test_marks_stand_right_beside_their_shelf_however_long_its_number() -> None:
    snapshot = with_shelves(500, goal(Phase.MOVING))._replace(
        history=(ended(3, Phase.ABORTED, ""),)
    )
    app = stub_app(snapshot, size=TALL)
    async with app.run_test(size=TALL) as pilot:
        await pilot.pause()
        shown = [app.main.goal.board.render_line(y).text for y in range(2)]
    assert [line.find(part) for line, part in zip(shown, ("  3✗", " ▶12 "), strict=True)] == [11, 5]
