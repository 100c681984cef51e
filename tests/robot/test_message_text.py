"""A message as YAML and as JSON: long arrays by range, what JSON lacks, and fields by path."""

from __future__ import annotations

import json
import math
from array import array
from typing import Any

import pytest
import yaml
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterValue
from std_msgs.msg import Float32, Float32MultiArray, Header, String, UInt8MultiArray

from archo_tui.base.errors import ArchoError
from archo_tui.robot.messages import text
from archo_tui.robot.messages.text import as_data, as_text

EVENT = ParameterEvent(
    node="/n",
    new_parameters=[Parameter(name="p", value=ParameterValue(type=3, double_value=0.25))],
)


def test_a_message_is_yaml_as_ros_writes_it() -> None:
    header = Header(frame_id="map")
    header.stamp.sec = 7
    assert as_text(header) == "stamp:\n  sec: 7\n  nanosec: 0\nframe_id: map"
    assert yaml.safe_load(as_text(EVENT))["new_parameters"][0]["value"]["double_value"] == 0.25


def test_a_float32_has_the_digits_that_were_sent() -> None:
    for value in (0.1, 87.5, -3.4e38, 1e-45, math.inf, -math.inf):
        sent = array("f", [value])[0]
        shown = yaml.safe_load(as_text(Float32(data=sent)))["data"]
        assert array("f", [shown])[0] == sent
    assert as_text(Float32(data=array("f", [0.1])[0])) == "data: 0.1"
    assert as_text(Float32(data=math.nan)) == "data: .nan"


def test_short_arrays_are_shown_whole_and_long_ones_by_range() -> None:
    short, long = (
        Float32MultiArray(data=[0.5] * 20),
        Float32MultiArray(data=[0.5] * 20 + [math.nan]),
    )
    assert yaml.safe_load(as_text(short))["data"] == [0.5] * 20
    assert yaml.safe_load(as_text(long))["data"] == "float32[21], 0.5 .. 0.5, 1 nan"
    empty = Float32MultiArray(data=[math.nan] * 30)
    assert yaml.safe_load(as_text(empty))["data"] == "float32[30], 30 nan"
    image = UInt8MultiArray(data=bytes(range(200)))
    first = "00 01 02 03 04 05 06 07 08 09 0a 0b 0c 0d 0e 0f"
    assert yaml.safe_load(as_text(image))["data"] == f"uint8[200], {first} ..."
    many = ParameterEvent(new_parameters=[Parameter()] * 21)
    text = yaml.safe_load(as_text(many))["new_parameters"]
    assert text == "rcl_interfaces/Parameter[21]"


def test_json_has_whole_arrays_and_texts_for_what_it_lacks() -> None:
    values = [*(number / 2 for number in range(500)), math.nan, math.inf, -math.inf]
    told = as_data(Float32MultiArray(data=values))
    assert told["data"] == [*values[:500], "nan", "inf", "-inf"]
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    large = as_data(Float32MultiArray(data=[float(n) for n in range(100_000)]))
    assert large["data"] == {"type": "float32[100000]", "least": 0.0, "greatest": 99999.0}


def test_what_does_not_fit_is_not_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text, "_MAX_JSON", 600)
    wide = Float32MultiArray(data=[0.25] * 300)
    assert as_data(wide)["data"] == {"type": "float32[300]", "least": 0.25, "greatest": 0.25}
    with pytest.raises(ArchoError, match="not shown: more than 0 kB as JSON: name fields"):
        as_data(ParameterEvent(new_parameters=[Parameter()] * 10))
    assert len(as_text(String(data="x" * 10_000))) < 600


def test_fields_are_chosen_by_path() -> None:
    paths = ("new_parameters[0].value.double_value", "stamp", "node")
    assert as_text(EVENT, paths) == (
        'new_parameters[0].value.double_value: 0.25\nstamp: {sec: 0, nanosec: 0}\nnode: "/n"'
    )
    assert as_data(EVENT, paths)["new_parameters[0].value.double_value"] == 0.25


@pytest.mark.parametrize(
    ("path", "why"),
    [
        ("nod", "there is no field nod (nearest: node)"),
        ("stamp.x", "there is no field stamp.x: stamp has sec, nanosec"),
        ("node.x", "there is no field node.x"),
        ("node[0]", "there is no node[0]: node is no array"),
        ("new_parameters[1]", "there is no new_parameters[1]: new_parameters has 1 elements"),
        ("new_parameters.name", "there is no field new_parameters.name"),
        ("__class__", "there is no field __class__: the message has stamp, node, new_parameters"),
        ("\x1b[2J", "there is no field \N{REPLACEMENT CHARACTER}[2J"),
        ("", "there is no field "),
    ],
)
def test_a_wrong_field_is_one_line(path: str, why: str) -> None:
    shown: Any = (as_text, as_data)
    for show in shown:
        with pytest.raises(ArchoError) as raised:
            show(EVENT, (path,))
        assert str(raised.value).startswith(why)


def test_a_text_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text, "_MAX_LINES", 3)
    (*_, last) = as_text(EVENT).splitlines()
    assert last.startswith("... and ")
    assert last.endswith(" more lines: name fields")
