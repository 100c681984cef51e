"""The text of interface definitions: files with comments, nested types, and broken packages."""

from __future__ import annotations

from pathlib import Path

import pytest

from archo_tui.robot.messages import definitions
from archo_tui.robot.messages.definitions import definition_text, names_in, read_names, value_names


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


# The names of values come from the constants of a type, and none is guessed.


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
