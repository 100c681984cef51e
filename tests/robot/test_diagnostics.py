"""The table of diagnostic statuses: levels, silence, and names without end."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from archo_tui.robot.state.readings import DiagnosticLevel
from archo_tui.robot.telemetry import Diagnostics

pytestmark = pytest.mark.pure


def array(*parts: tuple[str, Any, str], hardware: str = "") -> Any:
    return SimpleNamespace(
        status=[
            SimpleNamespace(name=name, level=level, message=message, hardware_id=hardware)
            for name, level, message in parts
        ]
    )


def found(table: Diagnostics) -> list[tuple[str, str, str]]:
    return [(status.part, status.level.value, status.message) for status in table.all]


def test_a_level_is_a_byte_or_a_number() -> None:
    table = Diagnostics()
    table.add(array(("a", b"\x02", "hot"), ("b", 1, ""), ("c", b"\x00", "")), 0.0)
    assert [status.level.value for status in table.all] == ["ERROR", "WARN", "OK"]
    assert table.all[0].message == "hot"


def test_a_level_that_nobody_knows_is_an_error() -> None:
    table = Diagnostics()
    table.add(array(("a", b"\x09", "")), 0.0)
    assert table.all[0].level is DiagnosticLevel.ERROR


def test_silence_of_three_periods_and_five_seconds_is_stale() -> None:
    table = Diagnostics()
    for second in range(20):
        table.add(array(("quick", 0, "")), float(second))
        if second % 4 == 0:
            table.add(array(("slow", 0, "")), float(second))
    quick, slow = table.all
    assert quick.level_at(23.9) is DiagnosticLevel.OK
    assert quick.level_at(24.1) is DiagnosticLevel.STALE
    assert slow.level_at(24.1) is DiagnosticLevel.OK
    assert slow.level_at(28.1) is DiagnosticLevel.STALE


def test_names_without_end_do_not_fill_the_memory() -> None:
    table = Diagnostics()
    for number in range(1010):
        table.add(array((f"part {number}", 0, "")), 0.0)
    assert len(table.all) == 1000


def test_an_error_takes_the_place_of_a_part_that_is_well() -> None:
    table = Diagnostics()
    table.add(array(*((f"part {number}", 0, "") for number in range(1000))), 0.0)
    table.add(array(("late", 2, "hot"), ("later", 0, "")), 1.0)
    assert len(table.all) == 1000
    bad = [status.name for status in table.all if status.level is not DiagnosticLevel.OK]
    assert bad == ["late"]
    table.add(array(*((f"bad {number}", 2, "") for number in range(1010))), 2.0)
    assert len(table.all) == 1000


def test_parts_of_one_name_differ_by_their_hardware() -> None:
    table = Diagnostics()
    both = array(("motor", 2, "burnt"), hardware="left")
    both.status += array(("motor", 0, "fine"), hardware="right").status
    table.add(both, 0.0)
    assert found(table) == [("motor (left)", "ERROR", "burnt"), ("motor (right)", "OK", "fine")]
    table.add(both, 1.0)


def test_the_worst_of_several_statuses_of_a_part_in_one_array_stays() -> None:
    table = Diagnostics()
    for second in range(20):
        table.add(array(("a", 1, "w"), ("a", 2, "e"), ("a", 3, "s"), ("a", 0, "")), float(second))
    assert found(table) == [("a", "ERROR", "e")]
    assert table.all[0].period == 1.0


def test_a_status_without_hardware_makes_way_unless_it_is_bad() -> None:
    table = Diagnostics()
    table.add(array(("motor", 0, "Node starting up"), ("fan", 2, "stuck")), 0.0)
    table.add(array(("motor", 0, "fine"), ("fan", 0, "turns"), hardware="sn 12"), 1.0)
    assert found(table) == [
        ("fan", "ERROR", "stuck"),
        ("fan (sn 12)", "OK", "turns"),
        ("motor (sn 12)", "OK", "fine"),
    ]


def test_a_part_is_forgotten_until_it_reports_again() -> None:
    table = Diagnostics()
    table.add(array(("motor", 2, "burnt"), hardware="left"), 0.0)
    table.forget(("motor", "left"))
    assert table.all == ()
    table.add(array(("motor", 2, "burnt"), hardware="left"), 1.0)
    assert len(table.all) == 1
