"""Parameter files: names that nobody declares are pointed at, with the nearest."""

from __future__ import annotations

from pathlib import Path

import pytest

from archo_tui.ros.embedded.parameter_files import read
from archo_tui.station import parameter_files
from tests.support.console import console

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


def test_unknown_names_are_said_with_the_nearest(tmp_path: Path) -> None:
    file = tmp_path / "shared.yaml"
    file.write_text(TEXT)
    declared = {"/motor_controller": {"max_speed", "wheel_radius"}, "/dashboard": set[str]()}
    assert parameter_files.unknown_lines(read(file), declared) == [
        f"{file}:3: no node /motor_controler here (nearest: /motor_controller)",
        f"{file}:6: /motor_controller has no parameter max_sped (nearest: max_speed)",
    ]


def test_what_is_typed_for_every_node_is_known_to_one_at_least() -> None:
    declared = {"/motor_controller": {"max_speed", "wheel_radius"}, "/dashboard": set[str]()}
    words = [
        "-r",
        "a:=b",
        "-p",
        "max_sped:=1",
        "-p",
        "max_speed:=1",
        "--param",
        "motor_controller:max_sped:=2",
    ]
    assert parameter_files.unknown_lines(parameter_files.parse_typed(words), declared) == [
        "-p max_sped:=1: no node has a parameter max_sped (nearest: max_speed)",
        "-p motor_controller:max_sped:=2: /motor_controller has no parameter max_sped "
        "(nearest: max_speed)",
    ]


async def test_a_misspelled_parameter_behind_ros_args_is_an_event() -> None:
    async with console("-p", "max_sped:=1") as op:
        await op.until("-p max_sped:=1: no node has a parameter max_sped (nearest: max_speed)")


def test_a_file_of_a_whole_stack_is_one_line(tmp_path: Path) -> None:
    file = tmp_path / "nav2.yaml"
    names = ("amcl", "bt_navigator", "controller_server", "map_server", "planner_server")
    parameters = "".join(f"    p{number}: 1\n" for number in range(80))
    file.write_text("".join(f"{name}:\n  ros__parameters:\n{parameters}" for name in names))
    assert parameter_files.unknown_lines(read(file), {"/motor_controller": {"max_speed"}}) == [
        f"{file}: 5 of its nodes are not here: /amcl, /bt_navigator, /controller_server ..."
    ]


async def test_unknown_names_are_events_on_the_screen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path("shared.yaml")
    file.write_text(TEXT)
    async with console(params_files=[file]) as op:
        await op.until("no node /motor_controler here (nearest: /motor_controller)")
        await op.until("has no parameter max_sped (nearest: max_speed)")


async def test_a_later_file_wins(tmp_path: Path) -> None:
    first, second = tmp_path / "1.yaml", tmp_path / "2.yaml"
    for file, speed in ((first, 0.3), (second, 1.7)):
        file.write_text(f"motor_controller:\n  ros__parameters:\n    max_speed: {speed}\n")
    async with console(params_files=[first, second]) as op:
        await op.until("1.7    double")


def test_the_projects_own_files_are_in_ros_form() -> None:
    own = parameter_files.load_files(parameter_files.default_files())
    assert {(o.pattern, o.name) for o in own} >= {
        ("motor_controller", "max_speed"),
        ("motor_controller", "wheel_radius"),
    }
