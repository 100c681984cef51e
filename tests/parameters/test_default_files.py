"""ARCHO's own parameter files are for ARCHO's own nodes: nobody named them."""

from __future__ import annotations

from pathlib import Path

import pytest

from archo_tui.station.parameter_files import default_files
from tests.support.plain import operated

MOTOR = """
import rclpy
from rclpy.node import Node


class Motor(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.declare_parameter("max_speed", 1.5)
        self.declare_parameter("wheel_radius", 7)  # An integer, unlike ARCHO's own.
        self.get_logger().warning(f"speed {self.get_parameter('max_speed').value}")


def main():
    rclpy.init()
    rclpy.spin(Motor())


if __name__ == "__main__":
    main()
"""


@pytest.fixture
def motor(here: Path) -> Path:
    file = here / "motor.py"
    file.write_text(MOTOR)
    return file


async def test_a_node_of_ones_own_has_the_values_of_its_own_file(motor: Path) -> None:
    async with operated(node_files=[motor], only=True) as person:
        await person.until("WARN motor_controller: speed 1.5")
        person.type("get motor_controller wheel_radius\n")
        await person.until("wheel_radius is 7")
        assert "motor_params.yaml" not in person.said


async def test_in_the_place_of_archos_own_node_that_is_said(motor: Path) -> None:
    async with operated(node_files=[motor]) as person:
        await person.until(
            "INFO motor_controller: max_speed, wheel_radius: the default of motor.py; "
            "motor_params.yaml is for ARCHO's own node, --params-file gives it to yours"
        )


async def test_a_file_that_is_named_is_for_every_node(motor: Path, here: Path) -> None:
    motor.write_text(MOTOR.replace('"wheel_radius", 7', '"wheel_radius", 0.07'))
    (named,) = (path for path in default_files() if path.name == "motor_params.yaml")
    async with operated(node_files=[motor], params_files=[named]) as person:
        await person.until("WARN motor_controller: speed 0.8")
        assert "the default of motor.py" not in person.said


async def test_archos_own_nodes_have_them_and_what_the_user_gives_wins(here: Path) -> None:
    mine = here / "mine.yaml"
    mine.write_text("motor_controller:\n  ros__parameters:\n    max_speed: 0.5\n")
    async with operated(params_files=[mine], ros_args=["-p", "wheel_radius:=0.06"]) as person:
        person.type("get motor_controller max_speed\n")
        await person.until("max_speed is 0.5")
        person.type("get motor_controller wheel_radius\n")
        await person.until("wheel_radius is 0.06")
        person.type("get battery_monitor publish_period\n")
        await person.until("publish_period is 1.0")
