"""The names of values come from the constants of a type, and none is guessed."""

from __future__ import annotations

from archo_tui.robot.messages.definitions import read_names, value_names


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
