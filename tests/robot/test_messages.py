"""Messages as text and as data, the definitions of their types, and which classes are loaded."""

from __future__ import annotations

import importlib
import json
import math
import sys
import threading
from array import array
from pathlib import Path
from typing import Any

import pytest
import yaml
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterValue
from std_msgs.msg import Float32, Float32MultiArray, Header, String, UInt8MultiArray

from archo_tui.base.errors import ArchoError
from archo_tui.robot.messages import definitions, text
from archo_tui.robot.messages.definitions import definition_text, names_in, read_names, value_names
from archo_tui.robot.messages.text import as_data, as_text
from archo_tui.robot.messages.types import load_class
from archo_tui.session.session import _robots_nodes
from tests.support.quiet import ended, until
from tests.support.robot import robot

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


# The text of interface definitions: files with comments, nested types, and broken packages.


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the empty folder for messages of an installed package `odd_msgs`."""
    folder = tmp_path / "share" / "odd_msgs" / "msg"
    folder.mkdir(parents=True)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    return folder


def test_a_message_is_shown_with_its_comments() -> None:
    text = definition_text("archo_interfaces/msg/MotorStatus") or ""
    assert text.startswith("# State of the drive, published on motor_status.\nint64 encoder_ticks ")
    assert "float32 speed           # m/s along the route, 0 when the robot stands" in text


def test_the_parts_of_services_and_actions_are_separated() -> None:
    service = definition_text("std_srvs/srv/Trigger") or ""
    assert [line.split(" #")[0].strip() for line in service.splitlines()] == [
        "---",
        "bool success",
        "string message",
    ]
    action = definition_text("archo_interfaces/action/MoveToShelf") or ""
    assert action.splitlines().count("---") == 2


def test_nested_types_stand_below_their_field_without_comments() -> None:
    text = definition_text("std_msgs/msg/Header") or ""
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert lines == [
        "builtin_interfaces/Time stamp",
        "    int32 sec",
        "    uint32 nanosec",
        "string frame_id",
    ]


def test_arrays_of_messages_of_the_same_package_are_nested(package: Path) -> None:
    (package / "Inner.msg").write_text("# left out\nuint8 A=1  # also left out\n\nfloat64 x # m\n")
    (package / "Outer.msg").write_text("Inner[<=3] some\t# kept\nstring<=5 word\nInner last\n")
    assert definition_text("odd_msgs/msg/Outer") == "\n".join(
        (
            "Inner[<=3] some # kept",
            "    uint8 A=1",
            "    float64 x",
            "string<=5 word",
            "Inner last",
            "    uint8 A=1",
            "    float64 x",
        )
    )
    assert names_in("odd_msgs") == ["odd_msgs/msg/Inner", "odd_msgs/msg/Outer"]


def test_a_broken_package_has_an_end(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (package / "A.msg").write_text("B b\n")
    (package / "B.msg").write_text("A a\nA again\nabsent_msgs/Gone gone\n")
    assert definition_text("odd_msgs/msg/A") == (
        "B b\n    A a\n    A again\n    absent_msgs/Gone gone"
    )
    monkeypatch.setattr(definitions, "_MAX_LINES", 3)
    (package / "Wide.msg").write_text("B b\n" * 1000)
    assert (definition_text("odd_msgs/msg/Wide") or "").splitlines()[3:] == [
        "... and more: these are the first 3 lines"
    ]


def test_what_is_not_installed_has_no_definition() -> None:
    for name in ("std_msgs/msg/Strin", "nosuch/msg/A", "json/msg/A", "../msg/A", "String", ""):
        assert definition_text(name) is None, name
    assert names_in("json") == []


def test_without_its_file_a_type_is_derived_from_its_class(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(definitions, "_folders", lambda _: [])
    text = definition_text("archo_interfaces/action/MoveToShelf") or ""
    assert text.splitlines() == [
        "# Derived from the installed class: its file, with comments, was not found.",
        "int32 shelf_number",
        "---",
        "bool success",
        "string final_message",
        "---",
        "float32 distance_remaining",
        "string status",
    ]
    assert "uint8" not in (definition_text("std_srvs/srv/Trigger") or "")


def test_constants_name_the_values_of_their_field() -> None:
    names = read_names(
        """
        uint8 POWER_SUPPLY_STATUS_FULL=4  # not for the health
        uint8 POWER_SUPPLY_STATUS_UNKNOWN = 0
        uint8 POWER_SUPPLY_HEALTH_GOOD=1
        string FULL="full"
        uint8 power_supply_status
        uint8 power_supply_health
        uint8 other
        """.replace("        ", "").splitlines()
    )
    assert names == {
        "power_supply_status": {4: "FULL", 0: "UNKNOWN"},
        "power_supply_health": {1: "GOOD"},
    }


def test_other_constants_belong_to_the_only_field_of_their_type() -> None:
    lines = ["uint8 DEBUG=10", "uint8 level", "uint32 line"]
    assert read_names(lines) == {"level": {10: "DEBUG"}}
    assert read_names([*lines, "uint8 second"]) == {}


def test_the_definition_is_that_of_the_installed_type() -> None:
    assert value_names("rcl_interfaces/msg/Log")["level"][30] == "WARN"
    assert value_names("nowhere_msgs/msg/Nothing") == {}


# A type's name comes from the graph or a file: nothing but interfaces is imported for it.


@pytest.mark.parametrize(
    "name", ["evil/msg/X", "evil.inner/msg/X", "evil/inner/X", "../msg/X", "", "/msg/X", "a/b/c/d"]
)
def test_a_module_that_is_no_package_of_interfaces_is_not_imported(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "evil").mkdir()
    for file in ("__init__.py", "inner.py"):
        (tmp_path / "evil" / file).write_text("raise SystemExit('imported')\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert load_class(name) is None
    assert "evil" not in sys.modules


def test_interfaces_are_found_by_their_names() -> None:
    assert load_class("std_msgs/msg/String").__name__ == "String"
    assert load_class("archo_interfaces/action/MoveToShelf").__name__ == "MoveToShelf"


async def test_a_class_of_the_robot_file_is_loaded_before_the_ros_thread_needs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a slow disk the first import takes long, and a STOP would wait for it."""
    loaded: list[tuple[str, str]] = []
    load = importlib.import_module

    def noted(name: str, package: str | None = None) -> Any:
        if package is None:  # rclpy's own imports are relative ones.
            loaded.append((threading.current_thread().name, name))
        return load(name, package)

    monkeypatch.setattr(importlib, "import_module", noted)
    async with robot(*_robots_nodes(False).values()) as it:
        await until(lambda: it.snapshot.battery.percentage is not None)
        assert (await ended(it.emergency_stop())).ok
    on_ros_thread = {module for thread, module in loaded if thread == "archo-client"}
    before = {module for thread, module in loaded if thread == threading.main_thread().name}
    assert on_ros_thread
    assert on_ros_thread <= before
