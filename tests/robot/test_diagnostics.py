"""The table of diagnostic statuses: levels, silence, and names without end."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from archo_tui.robot.diagnostics import Diagnostics
from archo_tui.robot.state import DiagnosticLevel


def array(*parts: tuple[str, Any, str]) -> Any:
    return SimpleNamespace(
        status=[
            SimpleNamespace(name=name, level=level, message=message, hardware_id="")
            for name, level, message in parts
        ]
    )


def test_a_level_is_a_byte_or_a_number() -> None:
    table = Diagnostics()
    assert table.add(array(("a", b"\x02", "hot"), ("b", 1, ""), ("c", b"\x00", "")), 0.0)
    assert [status.level.value for status in table.all] == ["ERROR", "WARN", "OK"]
    assert table.all[0].message == "hot"


def test_a_level_that_nobody_knows_is_an_error() -> None:
    table = Diagnostics()
    table.add(array(("a", b"\x09", "")), 0.0)
    assert table.all[0].level is DiagnosticLevel.ERROR


def test_only_a_level_that_differs_is_news() -> None:
    table = Diagnostics()
    assert table.add(array(("a", 0, "1")), 0.0)
    assert not table.add(array(("a", 0, "2")), 1.0)
    assert table.all[0].message == "2"
    assert table.add(array(("a", 1, "2")), 2.0)


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
    for number in range(3000):
        table.add(array((f"part {number}", 0, "")), 0.0)
    assert len(table.all) == 1000


def test_an_error_takes_the_place_of_a_part_that_is_well() -> None:
    table = Diagnostics()
    table.add(array(*((f"part {number}", 0, "") for number in range(1000))), 0.0)
    assert table.add(array(("late", 2, "hot"), ("later", 0, "")), 1.0)
    assert len(table.all) == 1000
    bad = [status.name for status in table.all if status.level is not DiagnosticLevel.OK]
    assert bad == ["late"]
    for number in range(3000):
        table.add(array((f"bad {number}", 2, "")), 2.0)
    assert len(table.all) == 1000
