"""What a start on real ROS 2 refuses: one line, from whichever of ROS's layers it came."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

FAST = "motor_controller:\n  ros__parameters:\n    max_speed: 9.0\n"
OUT = "Invalid parameter value (9.0) for parameter. Reason: Parameter max_speed out of range"


def refused(*words: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Start the console on ROS 2, with options of `subprocess.run`, and return how it ended."""
    return subprocess.run(
        [sys.executable, "-m", "archo_tui", "--engine", "ros2", *words],
        capture_output=True,
        text=True,
        check=False,
        stdin=subprocess.DEVNULL,
        timeout=60,
        **options,
    )


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
def test_it_is_said_in_one_line(words: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "fast.yaml").write_text(FAST)
    done = refused(*words.split(), cwd=tmp_path)
    ours = [line for line in done.stderr.splitlines() if "[rcl]" not in line]  # rcl logs it too
    assert len(ours) == 1, done.stderr
    assert ours[0].startswith(f"archo-tui: {said}")
    assert (done.returncode, done.stdout) == (2, "")


@pytest.mark.parametrize("words", ["--plain", "--attach --plain", "status"])
def test_a_middleware_that_is_not_installed_is_one_line_too(words: str) -> None:
    done = refused(*words.split(), env=os.environ | {"RMW_IMPLEMENTATION": "rmw_nosuch_cpp"})
    assert done.stderr.startswith(
        "archo-tui: RMW_IMPLEMENTATION names rmw_nosuch_cpp, which is not installed"
    )
    assert re.search(r"install ros-\w+-rmw-nosuch-cpp, or unset RMW_IMPLEMENTATION", done.stderr)
    assert (done.stderr.count("\n"), done.returncode, done.stdout) == (1, 2, "")
