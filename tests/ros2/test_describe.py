"""`archo-tui robot`: the file that it writes for a robot in the field operates that robot."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("sensor_msgs")

from tests.ros2.conftest import Processes
from tests.ros2.test_from_a_shell import ended
from tests.support.waiting import DEADLINE


def written(processes: Processes, *words: str) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, "-m", "archo_tui", "robot", *words],
        env=processes.environment,
        capture_output=True,
        text=True,
        timeout=2 * DEADLINE,
    )
    return done.returncode, done.stdout, done.stderr


def test_the_written_file_shows_and_commands_the_robot(
    processes: Processes, tmp_path: Path
) -> None:
    processes.start("tests.robots.field", "-r", "__ns:=/tb1")
    file = tmp_path / "tb1.yaml"
    code, out, err = written(processes, "--out", str(file))
    assert (code, err) == (0, "")
    assert out == f"Written to {file}. Check every line: nothing in it was tried.\n"
    text = file.read_text()
    assert "domain" in text
    assert f"{processes.domain}, 20" in text
    assert "battery_state is a sensor_msgs/msg/BatteryState, 2.0 Hz" in text
    words = "--namespace", "/tb1", "--robot", str(file)
    code, out, _ = ended(processes, *words, "status", "--line")
    assert (code, out[:4]) == (0, "tb1 ")
    assert "75 %" in out
    assert ended(processes, *words, "lamp", "--yes") == (0, "", "on\n")
    again = written(processes, "--out", str(file))
    assert again == (2, "", f"archo-tui: {file} already exists: name another file\n")


@pytest.mark.waits
def test_two_robots_are_named_and_none_is_written(processes: Processes) -> None:
    for number in (1, 2):
        processes.start("tests.robots.field", "-r", f"__ns:=/tb{number}")
    said = "archo-tui: several robots are here, in /tb1, /tb2: name one with --namespace\n"
    assert written(processes) == (2, "", said)
    code, out, _ = written(processes, "--namespace", "/tb2")
    assert (code, "topic: battery_state" in out) == (0, True)


def test_without_a_robot_it_fails_in_a_line(processes: Processes) -> None:
    code, out, err = written(processes)
    assert (code, out) == (1, "")
    assert err.startswith(f"archo-tui: no robot is on domain {processes.domain}")
