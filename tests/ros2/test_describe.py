"""Robots in the field: `look` finds them, and the file that `robot` writes operates one."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("sensor_msgs")

from tests.ros2.conftest import Processes


def test_the_written_file_shows_and_commands_the_robot(
    processes: Processes, tmp_path: Path
) -> None:
    processes.start("tests.robots.field", "-r", "__ns:=/tb1")
    file = tmp_path / "tb1.yaml"
    code, out, err = processes.run("robot", "--out", str(file))
    assert (code, err) == (0, "")
    assert out == f"Written to {file}. Check every line: nothing in it was tried.\n"
    text = file.read_text()
    assert "domain" in text
    assert f"{processes.domain}, 20" in text
    assert "battery_state is a sensor_msgs/msg/BatteryState, 2.0 Hz" in text
    words = "--namespace", "/tb1", "--robot", str(file)
    code, out, _ = processes.verb(*words, "status", "--line")
    assert (code, out[:4]) == (0, "tb1 ")
    assert "75 %" in out
    assert processes.verb(*words, "lamp", "--yes") == (0, "", "on\n")
    again = processes.run("robot", "--out", str(file))
    assert again == (2, "", f"archo-tui: {file} already exists: name another file\n")


@pytest.mark.waits
def test_two_robots_are_named_and_none_is_written(processes: Processes) -> None:
    for number in (1, 2):
        processes.start("tests.robots.field", "-r", f"__ns:=/tb{number}")
    said = "archo-tui: several robots are here, in /tb1, /tb2: name one with --namespace\n"
    assert processes.run("robot") == (2, "", said)
    code, out, _ = processes.run("robot", "--namespace", "/tb2")
    assert (code, "topic: battery_state" in out) == (0, True)


def test_without_a_robot_it_fails_in_a_line(processes: Processes) -> None:
    code, out, err = processes.run("robot")
    assert (code, out) == (1, "")
    assert err.startswith(f"archo-tui: no robot is on domain {processes.domain}")


def test_look_finds_a_robot_in_another_domain(processes: Processes) -> None:
    processes.domain = 17
    processes.start("tests.robots.field", "-r", "__ns:=/looked_for")
    while "/looked_for/base" not in (looked := processes.run("look"))[1]:
        pass
    assert looked[0] == 0
    line = next(line for line in looked[1].splitlines() if line.startswith("domain 17: "))
    assert line.endswith(": start with ROS_DOMAIN_ID=17")
