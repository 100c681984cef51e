"""The texts of a topic's fields: what fits stands there, and a number is short."""

from __future__ import annotations

import math
import sys
from typing import Any

import pytest

from archo_tui.robot.topics.rows import FieldKind, FieldView, TopicView
from archo_tui.screen.terminal.ascii import in_ascii
from archo_tui.text.topic import (
    field_columns,
    field_line,
    range_text,
    sparkline,
    summary,
    topic_plots,
    value_text,
)
from tests.support.clock import TIME
from tests.support.states import plain_text

VALUE, ARRAY = FieldKind.VALUE, FieldKind.ARRAY
SPEED = FieldView("twist.speed", VALUE, "float32", 0.8, unit="m/s", least=0.0, greatest=0.8)
RANGES = FieldView(
    "ranges", ARRAY, "float32[360]", unit="m", least=1.809727e-05, greatest=9.99999, nan=4
)


def line(field: FieldView, width: int) -> str:
    """The row of a field in so many cells."""
    return field_line(field, field_columns([SPEED, RANGES], width), (), ())[0]


def test_a_value_has_its_unit_or_the_name_of_its_type_for_it() -> None:
    assert value_text(SPEED) == "0.8 m/s"
    assert value_text(SPEED._replace(value=math.nan)) == "nan"
    assert value_text(FieldView("level", VALUE, "uint8", 30, constant="WARN")) == "30 WARN"
    assert value_text(FieldView("n", VALUE, "int64", 137_976)) == "137 976"
    assert value_text(FieldView("on", VALUE, "bool", True)) == "true"
    assert value_text(FieldView("text", VALUE, "string", "a\x1b[2Jb")).isprintable()
    stamp = FieldView("stamp", VALUE, "builtin_interfaces/Time", TIME + 0.12, is_time=True)
    assert value_text(stamp).endswith(":20.120")
    assert value_text(stamp._replace(value=12.5)) == "12.500 s"
    assert value_text(stamp._replace(value=1e300)).endswith(" s")


def test_a_range_is_short_and_names_what_is_nan() -> None:
    assert range_text(RANGES) == "1.81e-05 .. 10, 4 nan"
    assert range_text(SPEED._replace(least=130_002.4, greatest=137_976)) == "130 002 .. 137 976"
    assert range_text(SPEED._replace(least=None)) == ""


def test_where_there_is_no_column_an_array_has_its_range_beside_its_shape() -> None:
    assert "float32[360] 1.81e-05 .. 10, 4 nan" in line(RANGES, 50)
    assert line(RANGES, 116).split("  ")[-1].strip() == "1.81e-05 .. 10, 4 nan"


def test_a_sparkline_shows_the_spike_of_a_column_and_gaps() -> None:
    assert sparkline((None, (0.0, 0.0), (0.0, 9.0), (9.0, 9.0), (0.0, 9.0))) == " ▁██▁"
    assert sparkline(((5.0, 5.0), (5.0, 5.0))) == "▁▁"
    assert sparkline((None, None)) == ""


EXTREMES = [
    (-1.7e308, 1.7e308),
    (-sys.float_info.max, sys.float_info.max),
    (0.0, 5e-324),
    (5e-324, 5e-324),
    (1.7e308, 1.7e308),
    (0.0, 1e-310),
    (-(2**63), 2**64 - 1),
]


@pytest.mark.parametrize(("low", "high"), EXTREMES)
def test_the_greatest_and_the_least_numbers_have_curves(low: float, high: float) -> None:
    values = ((low, low), (high, high)) * 4
    bars = sparkline(values)
    assert bars == ("▁█" * 4 if high - low > 1e-300 else bars)
    assert len(bars) == len(values)
    rows = topic_plots({}, {"a": values}, ["a"], (60, 9))
    assert not any("cannot be drawn" in plain_text(row) for row in rows)
    assert {len(plain_text(row)) for row in rows[1:-1]} == {15}
    field = FieldView("a", VALUE, "float64", high, least=low, greatest=high, curve=values)
    assert bars in field_line(field, field_columns([field], 116), (), ("a",))[0]


def test_a_plot_that_cannot_be_drawn_leaves_the_others() -> None:
    broken: Any = (("no number", 1.0),)
    plots = {"a": broken, "b": ((7.0, 7.0),) * 3}
    lines = [plain_text(row) for row in topic_plots({}, plots, ["a", "b"], (60, 9))]
    assert lines[1].startswith("✗ cannot be drawn: TypeError")
    assert "b --" in lines[4]
    assert len(lines) == 9


def test_the_summary_says_what_is_out_of_the_ordinary() -> None:
    view = TopicView("/scan", "sensor_msgs/msg/LaserScan", 3, 11.3, 700.0, 0.1)
    assert plain_text(summary(view, is_frozen=False)) == "11.3 Hz   700 B/s   0.1 s old"
    assert "frozen" in plain_text(summary(view, is_frozen=True))
    assert "only the first 0 fields" in plain_text(
        summary(view._replace(is_cut=True), is_frozen=False)
    )
    quiet = TopicView("/scan", "sensor_msgs/msg/LaserScan")
    assert plain_text(summary(quiet, is_frozen=False)) == "no message yet"
    lost = quiet._replace(fault="it has no publisher: waiting for one")
    assert plain_text(summary(lost, is_frozen=False)) == lost.fault


def test_plots_share_an_axis_and_those_without_room_are_counted() -> None:
    plots = {"a": ((0.0, 1.0), None, (5.0, 5.0)), "b": ((7.0, 7.0),) * 3}
    lines = [plain_text(row) for row in topic_plots({}, plots, ["a", "b"], (60, 9))]
    assert len(lines) == 9
    assert "a --" in lines[0]
    assert "b --" in lines[4]
    assert lines[-1].endswith(" now ")
    lines = [plain_text(row) for row in topic_plots({}, plots, ["a", "b"], (60, 4))]
    assert "1 more have no room" in lines[-1]
    assert plain_text(topic_plots({}, plots, ["a"], (60, 3))[0]) == "too small for the plot"


def test_everything_has_a_form_in_ascii() -> None:
    header = FieldView("header", FieldKind.GROUP, "std_msgs/Header")
    for field, closed in ((header, ()), (header, ("header",)), (RANGES, ())):
        text, _ = field_line(field, field_columns([field], 80), closed, ("header",))
        assert "?" not in in_ascii(text)
    assert in_ascii(" ‖ 1x") == " | 1x"  # `?` says that something is not known.
    assert in_ascii("↑ ↓ Recent goals, ←→ 1 s") == "^ v Recent goals, <> 1 s"
