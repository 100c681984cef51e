"""Units and names of values come from the definition of a type, and none is guessed."""

from __future__ import annotations

from archo_tui.robot.field_notes import notes_of, read_notes, unit_in


def test_a_unit_stands_in_the_comment_behind_a_field() -> None:
    for comment, unit in {
        "m/s along the route, 0 when the robot stands": "m/s",
        "state of charge, % of full, 0 .. 100": "%",
        "start angle of the scan [rad]": "rad",
        "time between scans [seconds]": "s",
        "Voltage in Volts (Mandatory)": "V",
        "Negative when discharging (A)  (If unmeasured NaN)": "A",
        "Current charge in Ah  (If unmeasured NaN)": "Ah",
        "Temperature in Degrees Celsius (If unmeasured NaN)": "°C",
        "A": "A",
    }.items():
        assert unit_in(comment) == unit, comment


def test_what_is_no_unit_in_a_comment_is_not_taken_for_one() -> None:
    for comment in (
        "",
        "ticks counted since the last reset",
        "true while the robot stands on its dock",
        "A flag of the driver",
        "N of points in the cloud",
        "Charge percentage on 0 to 1 range",
        "intensity data [device-specific units]",
        "row-major, 3 x 3 [see above]",
    ):
        assert unit_in(comment) == "", comment


def test_constants_name_the_values_of_their_field() -> None:
    notes = read_notes(
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
    assert notes.names == {
        "power_supply_status": {4: "FULL", 0: "UNKNOWN"},
        "power_supply_health": {1: "GOOD"},
    }


def test_other_constants_belong_to_the_only_field_of_their_type() -> None:
    lines = ["uint8 DEBUG=10", "uint8 level", "uint32 line"]
    assert read_notes(lines).names == {"level": {10: "DEBUG"}}
    assert read_notes([*lines, "uint8 second"]).names == {}


def test_the_definition_is_that_of_the_installed_type() -> None:
    assert notes_of("archo_interfaces/msg/BatteryStatus").units == {
        "percentage": "%",
        "voltage": "V",
    }
    assert notes_of("archo_interfaces/msg/MotorStatus").units == {"speed": "m/s"}
    assert notes_of("rcl_interfaces/msg/Log").names["level"][30] == "WARN"
    assert notes_of("nowhere_msgs/msg/Nothing").units == {}
