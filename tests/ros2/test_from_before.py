"""What was said before the console came: the log lines that nodes keep for ten seconds."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("sensor_msgs")

from tests.ros2.conftest import Processes
from tests.support.waiting import DEADLINE


def test_a_warning_from_before_the_start_is_an_event_once(processes: Processes) -> None:
    robot = subprocess.Popen(
        [sys.executable, "-m", "tests.robots.field"],
        env=processes.environment,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert robot.stderr is not None
    while "the base was started" not in robot.stderr.readline():
        assert robot.poll() is None
    console = subprocess.Popen(
        [sys.executable, "-m", "archo_tui", "--engine", "ros2", "--attach", "--plain"],
        env=processes.environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert console.stdin is not None
    assert console.stdout is not None
    try:
        said = ""
        while "the base was started" not in said:
            said = console.stdout.readline()
            assert said, "the console has ended"
        out, _ = console.communicate("events\n", timeout=DEADLINE)
    finally:
        for process in (console, robot):
            process.kill()
            with process:  # Closes its pipes.
                pass
    assert out.count("WARN base: the base was started") == 1  # in the list of events
