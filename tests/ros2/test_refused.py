"""What a start on real ROS 2 refuses: one line, from whichever of ROS's layers it came."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.ros2.conftest import Processes

FAST = "motor_controller:\n  ros__parameters:\n    max_speed: 9.0\n"
OUT = "Invalid parameter value (9.0) for parameter. Reason: Parameter max_speed out of range"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--params-file fast.yaml", f"fast.yaml:3: {OUT}"),
        ("--ros-args -p max_speed:=9.0", OUT),
        ("--namespace /dash-ed", "--namespace /dash-ed: only letters, digits and _"),
        ("--ros-args --bogus", "unknown ROS arguments: ['--bogus']"),
        ("--ros-args -r a", "failed to initialize rcl: Couldn't parse remap rule: '-r a'"),
        ("--ros-args -r __node:=a-b", "failed to initialize rcl: Couldn't parse remap rule"),
    ],
)
def test_it_is_said_in_one_line(
    words: str, said: str, processes: Processes, tmp_path: Path
) -> None:
    (tmp_path / "fast.yaml").write_text(FAST)
    code, out, err = processes.run("--engine", "ros2", *words.split(), cwd=tmp_path)
    ours = [line for line in err.splitlines() if "[rcl]" not in line]  # rcl logs it too
    assert len(ours) == 1, err
    assert ours[0].startswith(f"archo-tui: {said}")
    assert (code, out) == (2, "")


@pytest.mark.parametrize("words", ["--plain", "--attach --plain", "status"])
def test_a_middleware_that_is_not_installed_is_one_line_too(
    words: str, processes: Processes
) -> None:
    environment = processes.environment | {"RMW_IMPLEMENTATION": "rmw_nosuch_cpp"}
    code, out, err = processes.run("--engine", "ros2", *words.split(), env=environment)
    assert err.startswith(
        "archo-tui: RMW_IMPLEMENTATION names rmw_nosuch_cpp, which is not installed"
    )
    assert re.search(r"install ros-\w+-rmw-nosuch-cpp, or unset RMW_IMPLEMENTATION", err)
    assert (err.count("\n"), code, out) == (1, 2, "")
