"""Parameter files: what they mean, for whom they are, and what is said of names and values."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from archo_tui.base.yaml_text.bounded_yaml import YamlError
from archo_tui.ros.embedded.parameter_files import matches, read
from archo_tui.station import parameter_files
from tests.support.console import console
from tests.support.plain import operated

TEXT = """\
motor_controler:
  ros__parameters:
    max_speed: 0.5
motor_controller:
  ros__parameters:
    max_sped: 0.5
/**:
  ros__parameters:
    anything: 1
"""
DECLARED = {"/motor_controller": {"max_speed", "wheel_radius"}, "/dashboard": set[str]()}


def test_unknown_names_are_said_with_the_nearest(tmp_path: Path) -> None:
    file = tmp_path / "shared.yaml"
    file.write_text(TEXT)
    assert parameter_files.unknown_lines(read(file), DECLARED) == [
        f"{file}:3: no node /motor_controler here (nearest: /motor_controller)",
        f"{file}:6: /motor_controller has no parameter max_sped (nearest: max_speed)",
    ]


def test_what_is_typed_for_every_node_is_known_to_one_at_least() -> None:
    words = ["-r", "a:=b", "-p", "max_sped:=1", "-p", "max_speed:=1"]
    words += ["--param", "motor_controller:max_sped:=2"]
    assert parameter_files.unknown_lines(parameter_files.parse_typed(words), DECLARED) == [
        "-p max_sped:=1: no node has a parameter max_sped (nearest: max_speed)",
        "-p motor_controller:max_sped:=2: /motor_controller has no parameter max_sped "
        "(nearest: max_speed)",
    ]


def test_a_file_of_a_whole_stack_is_one_line(tmp_path: Path) -> None:
    file = tmp_path / "nav2.yaml"
    names = ("amcl", "bt_navigator", "controller_server", "map_server", "planner_server")
    parameters = "".join(f"    p{number}: 1\n" for number in range(80))
    file.write_text("".join(f"{name}:\n  ros__parameters:\n{parameters}" for name in names))
    assert parameter_files.unknown_lines(read(file), {"/motor_controller": {"max_speed"}}) == [
        f"{file}: 5 of its nodes are not here: /amcl, /bt_navigator, /controller_server ..."
    ]


async def test_unknown_names_are_events_on_the_screen_and_a_later_file_wins(here: Path) -> None:
    unknown, first, second = here / "shared.yaml", here / "1.yaml", here / "2.yaml"
    unknown.write_text(TEXT)
    for file, speed in ((first, 0.3), (second, 1.7)):
        file.write_text(f"motor_controller:\n  ros__parameters:\n    max_speed: {speed}\n")
    async with console("-p", "max_sped:=1", params_files=[unknown, first, second]) as op:
        await op.until("no node /motor_controler here (nearest: /motor_controller)")
        await op.until("has no parameter max_sped (nearest: max_speed)")
        await op.until("-p max_sped:=1: no node has a parameter max_sped (nearest: max_speed)")
        await op.until("1.7    double")


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


async def test_a_node_in_archos_place_has_its_own_values_which_is_said(
    motor: Path,
) -> None:
    async with operated(node_files=[motor], only=True) as person:
        await person.until("WARN motor_controller: speed 1.5")
        assert "motor_params.yaml" not in person.said
    async with operated(node_files=[motor]) as person:
        await person.enter("get motor_controller wheel_radius", "wheel_radius is 7")
        await person.until(
            "INFO motor_controller: max_speed, wheel_radius: the default of motor.py; "
            "motor_params.yaml is for ARCHO's own node, --params-file gives it to yours"
        )


async def test_a_file_that_is_named_is_for_every_node(motor: Path, here: Path) -> None:
    motor.write_text(MOTOR.replace('"wheel_radius", 7', '"wheel_radius", 0.07'))
    (named,) = (
        path for path in parameter_files.default_files() if path.name == "motor_params.yaml"
    )
    async with operated(node_files=[motor], params_files=[named]) as person:
        await person.until("WARN motor_controller: speed 0.8")
        assert "the default of motor.py" not in person.said


FAKED = "12:00:00 goal ABORTED"
SIGN = f"""
from rclpy.node import Node

class Sign(Node):
    def __init__(self):
        super().__init__("sign")
        text = "first\\n{FAKED}\\x1b[31m"
        self.declare_parameter("text", text)
        self.declare_parameter("texts", ["a", text])
        self.declare_parameter("name\\n{FAKED}", 1)
        self.create_timer(0.5, lambda: self.get_logger().warning(text))
"""


async def test_a_newline_in_a_value_or_a_log_line_begins_no_line(here: Path) -> None:
    file = here / "sign.py"
    file.write_text(SIGN)
    loads = here / "other.yaml"
    loads.write_text('sign:\n  ros__parameters:\n    text: "second\\n12:00:00 goal ABORTED"\n')
    async with operated(node_files=[file], only=True) as person:
        await person.until("WARN sign: first")
        person.type("params\nget sign text\nget sign texts\nload other.yaml\nno\nget sign text\n")
        await person.until("would be second")
        await person.enter("load other.yaml --yes\nget sign text", "sign text is second")
        lines = person.said.splitlines()
        assert sum(FAKED in line for line in lines) >= 7
        assert [line for line in lines if line.startswith(FAKED)] == []
        assert "\x1b[31m" not in person.said
    async with console(node_files=[file], only=True, wait=False) as op:
        await op.until("text")
        await op.until("first")
        lines = [line.strip(" │┃") for line in op.text.splitlines()]
        assert [line for line in lines if line.startswith(FAKED)] == []


async def test_a_long_list_is_cut_with_its_length(here: Path) -> None:
    file = here / "long.py"
    file.write_text(SIGN.replace('"name\\n12:00:00 goal ABORTED", 1', '"long", [7] * 70_000'))
    async with operated(node_files=[file], only=True) as person:
        await person.until("WARN sign: first")
        await person.enter("get sign long", "7, 7 ... (210000 characters), integer[]")
        assert len(person.said) < 5000


SHARE = Path(__file__).parent.parent / "share"
ANSWERS = json.loads((SHARE / "parameter_files_jazzy.json").read_text())
# The answers to the forms are those of Jazzy (rclpy 7.1), taken down once: each file was given to
# `rclpy.init` by `--params-file`, and the overrides of six nodes were read.
# What rcl reads as something else without a word, by a fault of its own, is refused here.
STRICTER = {
    *("value [[1]]", "value [[]]", "value [1, [2]]", "value [{a: 1}]", "block list of maps"),
    *("value {}", "parameter twice, other type", "scalar"),
}
# Numbers that nobody writes: too small for a double, or hexadecimal and no integer of 64 bits.
OTHER = {"value 1e-400", "value 0x1.8p1", "value 0x1p3", "value 0xffffffffffffffff"}
NODES = ("/n", "/m", "/a/n", "/a/b/n", "/n/m", "/motor")


def kind_of(value: Any) -> str:
    if isinstance(value, list):
        return f"{type(value[0]).__name__}[]" if value else "none"
    return type(value).__name__


def meaning(file: Path) -> Any:
    """What each node gets of a file, or that it is refused."""
    try:
        overrides = read(file)
    except YamlError as error:
        return "refused" if re.match(r".*file\.yaml(:\d+)?: ", str(error)) else str(error)
    found: dict[str, Any] = {}
    for node in NODES:
        for override in overrides:
            if matches(override.pattern, node):
                value = None if override.value == [] else override.value
                kind = kind_of(override.value)
                found.setdefault(node, {})[override.name] = [kind, repr(value)]
    return found


def test_a_file_means_what_rcl_makes_of_it(tmp_path: Path) -> None:
    file, wrong = tmp_path / "file.yaml", list[str]()
    for answer in ANSWERS:
        if answer["form"] in OTHER:
            continue
        file.write_bytes(answer["text"].encode())
        is_refused = "refused" in answer or answer["form"] in STRICTER
        if meaning(file) != ("refused" if is_refused else answer["nodes"]):
            wrong.append(answer["form"])
    assert wrong == []
