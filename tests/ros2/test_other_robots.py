"""Robots elsewhere: in other domains, and in other namespaces of this one."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("sensor_msgs")

from tests.ros2.conftest import Processes
from tests.support.waiting import DEADLINE


def looked(processes: Processes) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "archo_tui", "look"],
        env=processes.environment,
        capture_output=True,
        text=True,
        timeout=2 * DEADLINE,
    )


def test_look_finds_a_robot_in_another_domain(processes: Processes) -> None:
    processes.domain = 17
    processes.start("tests.robots.field", "-r", "__ns:=/looked_for")
    done = looked(processes)
    while "/looked_for/base" not in done.stdout:
        done = looked(processes)
    assert done.returncode == 0
    line = next(line for line in done.stdout.splitlines() if line.startswith("domain 17: "))
    assert line.endswith(": start with ROS_DOMAIN_ID=17")
