"""What is kept of a topic's fields: ranges, a minute of values, arrays by shape, and bounds."""

from __future__ import annotations

import math
import operator
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.msg import BatteryStatus
from rcl_interfaces.msg import Log, Parameter, ParameterEvent, ParameterValue
from std_msgs.msg import Byte, Float32, Float32MultiArray, Header, String, UInt8MultiArray

from archo_tui.robot.state.graph import in_namespace
from archo_tui.robot.topics import rows as row_module
from archo_tui.robot.topics.rows import SPAN, FieldKind, FieldView, TopicFields, TopicRequest
from archo_tui.robot_file.load import load
from archo_tui.robot_file.model import field_units
from tests.support.archo import ARCHO


def rows(message: Any, **open_arrays: int) -> dict[str, FieldView]:
    """The rows of one message by path."""
    fields = TopicFields({})
    fields.add(0.0, message, {})
    return {row.path: row for row in fields.rows(0.0, TopicRequest(open_arrays))}


def watched(*values: float, per_second: float = 1.0) -> FieldView:
    """The row of a number that had these values, one after the other, with its curve."""
    fields = TopicFields({})
    for number, value in enumerate(values):
        fields.add(number / per_second, Float32(data=value), {})
    now = (len(values) - 1) / per_second
    request = TopicRequest(visible=frozenset(["data"]), curve_columns=6, plotted=("data",))
    return fields.rows(now, request)[0]


def test_nested_messages_and_times_are_rows_below_their_own() -> None:
    header = Header(frame_id="map")
    header.stamp.sec, header.stamp.nanosec = 7, 500_000_000
    stamp, frame = rows(header).values()
    assert (stamp.path, stamp.value, stamp.is_time) == ("stamp", 7.5, True)
    assert (frame.path, frame.value, frame.kind) == ("frame_id", "map", FieldKind.VALUE)
    found = rows(Log(stamp=header.stamp, level=30))
    assert (found["level"].value, found["level"].constant) == (30, "WARN")
    value = rows(Parameter(value=ParameterValue(type=3, double_value=0.25)))
    assert value["value"].kind is FieldKind.GROUP
    assert value["value.double_value"].value == 0.25


def test_the_range_lasts_since_the_first_message_and_the_values_a_minute() -> None:
    row = watched(*[float(n) for n in range(100)])
    assert (row.least, row.greatest) == (0.0, 99.0)
    assert row.curve == ((40, 49), (50, 59), (60, 69), (70, 79), (80, 89), (90, 99))


def test_no_spike_within_a_tenth_of_a_second_is_lost() -> None:
    values = [0.0] * 3000
    values[1234] = 9.0
    row = watched(*values, per_second=100.0)
    assert row.curve.count((0.0, 9.0)) == 1
    assert row.greatest == 9.0


def test_a_value_holds_until_the_next_one_and_not_for_ever() -> None:
    fields = TopicFields({})
    for time in (0.0, 1.2, 2.4, 30.0):
        fields.add(time, Float32(data=time), {})
    request = TopicRequest(plotted=("data", "gone"), plot_columns=120)  # Half a second each.
    plots = fields.plots(30.0, request)
    assert list(plots) == ["data"]
    known = [column for column in plots["data"] if column is not None]
    first = plots["data"].index(known[0])
    assert None not in plots["data"][first : first + 6]
    assert plots["data"][first + 10 : -1].count(None) == len(plots["data"]) - first - 11
    assert fields.plots(31.0 + SPAN * 2, request)["data"] == (None,) * 120


def test_nan_and_inf_everywhere_are_values_without_a_range() -> None:
    row = watched(math.nan, math.inf, -math.inf, math.nan)
    assert math.isnan(row.value)  # type: ignore[arg-type]
    assert row.least is None
    assert row.curve == ()
    assert watched(math.nan, 2.0, math.inf).greatest == 2.0
    array = rows(Float32MultiArray(data=[math.nan] * 30))["data"]
    assert (array.type, array.nan, array.least) == ("float32[30]", 30, None)


def test_a_row_that_has_not_changed_is_the_same_object() -> None:
    fields = TopicFields({})
    fields.add(0.0, UInt8MultiArray(data=b"1"), {})
    first = fields.rows(0.3, TopicRequest())
    assert all(map(operator.is_, first, fields.rows(0.5, TopicRequest())))


def test_bytes_and_elements_that_are_shown_have_ranges_without_lost_spikes() -> None:
    fields, request = TopicFields({}), TopicRequest({"data": 40})
    for number in range(10):
        values = [0.0] * 50
        values[45] = 9.0 if number == 4 else 1.0
        fields.add(number / 100, Float32MultiArray(data=values), request.open_arrays)
    found = {row.path: row for row in fields.rows(0.1, request)}
    assert (found["data[45]"].least, found["data[45]"].greatest) == (1.0, 9.0)
    fields, request = TopicFields({}), TopicRequest({"new_parameters": 0})
    for gain in (0.5, 7.0, 1.0):
        value = ParameterValue(double_value=gain)
        event = ParameterEvent(new_parameters=[Parameter(value=value)])
        fields.add(
            1.0, event, {**request.open_arrays, "new_parameters[3].value.byte_array_value": 0}
        )
    found = {row.path: row for row in fields.rows(1.0, request)}
    assert found["new_parameters[0].value.double_value"].greatest == 7.0
    byte = TopicFields({})
    byte.add(1.0, Byte(data=b"\x07"), {})
    assert byte.rows(1.0, TopicRequest())[0].greatest == 7


def test_a_bool_has_a_curve_and_no_range() -> None:
    fields = TopicFields({})
    fields.add(0.0, BatteryStatus(is_charging=True), {})
    request = TopicRequest(visible=frozenset(["is_charging"]), curve_columns=2)
    row = next(row for row in fields.rows(0.0, request) if row.path == "is_charging")
    assert row.value is True
    assert row.least is None
    assert row.curve == (None, (True, True))


def test_an_array_is_a_row_until_it_is_opened_twenty_elements_at_a_time() -> None:
    long = Float32MultiArray(data=[float(n) for n in range(360)])
    closed = rows(long)["data"]
    assert (closed.type, closed.least, closed.greatest) == ("float32[360]", 0.0, 359.0)
    opened = rows(long, data=340)
    assert [path for path in opened if "[" in path] == [
        *(f"data[{number}]" for number in range(340, 360)),
        "data[]",
    ]
    assert opened["data[340]"].value == 340.0
    assert opened["data[]"].kind is FieldKind.MORE
    assert opened["data[]"].value == 360
    image = rows(UInt8MultiArray(data=bytes(range(200))))["data"]
    assert image.first.startswith("00 01 02")
    event = ParameterEvent(new_parameters=[Parameter(name="gain")])
    assert rows(event, new_parameters=0)["new_parameters[0].name"].value == "gain"


def test_the_fields_beyond_the_bound_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(row_module, "MAX_FIELDS", 3)
    fields = TopicFields({})
    fields.add(0.0, BatteryStatus(), {})
    assert len(fields.rows(0.0, TopicRequest())) == 3
    assert fields.is_cut
    fields.add(1.0, Header(), {})  # Of another definition.
    assert [row.path for row in fields.rows(1.0, TopicRequest())] == ["stamp", "frame_id"]
    assert not fields.is_cut


def test_a_long_text_is_cut() -> None:
    value = rows(String(data="x" * 5_000))["data"].value
    assert isinstance(value, str)
    assert len(value) == 504


def test_the_robot_file_names_units_of_fields_that_it_does_not_convert(tmp_path: Path) -> None:
    fields = TopicFields({"data": "bar"})
    fields.add(0.0, Float32(data=1.0), {})
    assert fields.rows(0.0, TopicRequest())[0].unit == "bar"

    def full(name: str) -> str:
        return in_namespace("/left", name)

    kind = "archo_interfaces/msg/BatteryStatus"
    assert field_units(ARCHO, full, "/left/battery_level", kind)["percentage"] == "%"
    assert field_units(ARCHO, full, "/battery_level", kind) == {}
    path = tmp_path / "robot.yaml"
    path.write_text(
        "gauges:\n"
        "- {title: Tank, topic: tank, type: std_msgs/msg/Float32, field: data, unit: l}\n"
        "- {title: Oil, topic: oil, type: std_msgs/msg/Float32, field: {field: data, scale: 10},"
        " unit: bar}\n"
    )
    file = load(path)
    assert field_units(file, full, "/left/tank", "std_msgs/msg/Float32") == {"data": "l"}
    assert field_units(file, full, "/left/oil", "std_msgs/msg/Float32") == {}
