"""The rows of Nodes: no rate disappears, and what is cut says so."""

from __future__ import annotations

import pytest

from archo_tui.robot.state.graph import NodeState
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.screen.widgets.nodes_panel import node_columns, node_lines, node_titles
from archo_tui.text.nodes import NodeRow
from tests.support.clock import NOW
from tests.support.front import front
from tests.support.states import NORMAL
from tests.support.stub import StandingClock


def row(name: str, rate: float | None = 5.0) -> NodeRow:
    return NodeRow(NodeState(name, NOW - 0.4, rate), None, NOW)


def drawn(rows: list[NodeRow], width: int) -> list[str]:
    columns = node_columns(rows, width)
    return [line for one in rows for line, _ in node_lines(one, width, columns)]


LONG = row("/warehouse/level_2/motor_controller", 97.3)


@pytest.mark.parametrize("width", range(23, 60))
def test_a_rate_stands_beside_a_long_name_at_every_width(width: int) -> None:
    first, second = drawn([LONG, row("/dashboard", None)], width)
    assert first.replace(" ", "").endswith("0.4s97.3Hz")
    assert len(first) == width
    assert first.startswith("● war")
    assert second.strip().endswith("0.4 s")


def test_a_name_that_is_cut_keeps_its_beginning_and_its_end() -> None:
    assert drawn([LONG], 40)[0] == "● warehouse/l…r_controller 0.4 s 97.3 Hz"
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
    name, line = drawn([crashed, LONG], width)[:2]
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
