"""Of a line of a list that changes, no more is drawn than what differs."""

from __future__ import annotations

from archo_tui.widgets.rows import changed_cells


def test_what_differs_is_drawn_and_what_is_near_with_it() -> None:
    assert changed_cells("speed  0.8 m/s", "speed  0.7 m/s", 40) == [(9, 10)]
    assert changed_cells("a 1 b 1", "a 2 b 2", 40) == [(2, 7)]
    far = " " * 20
    assert changed_cells(f"1{far}1", f"2{far}2", 40) == [(0, 1), (21, 22)]
    assert changed_cells("long", "lo", 40) == [(2, 4)]
    assert changed_cells("lo", "long", 40) == [(2, 4)]


def test_where_a_character_takes_two_cells_the_whole_line_is_drawn() -> None:
    assert changed_cells("棚 1", "棚 2", 40) == [(0, 40)]
    assert changed_cells("same", "same", 40) == [(0, 40)]
