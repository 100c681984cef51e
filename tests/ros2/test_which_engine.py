"""`archo-tui --engine ros2 stop` beside consoles of the other engine and of another domain."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from tests.ros2.conftest import Processes
from tests.support.waiting import DEADLINE


def environment(domain: int) -> dict[str, str]:
    return os.environ | {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}


@contextmanager
def console(processes: Processes, domain: int, *words: str) -> Iterator[subprocess.Popen[str]]:
    """A `--plain` that has said the state of its robot."""
    with processes.begin("--plain", *words, env=environment(domain)) as begun:
        assert begun.stdin is not None
        assert begun.stdout is not None
        begun.stdin.write("status\n")
        begun.stdin.flush()
        while not begun.stdout.readline().startswith("goal "):
            pass
        try:
            yield begun
        finally:
            begun.kill()


def stops(begun: subprocess.Popen[str]) -> int:
    """How many STOPs were confirmed, until its end."""
    out, _ = begun.communicate("status\n", timeout=2 * DEADLINE)
    return out.count("STOP: confirmed")


def test_a_stop_of_one_engine_and_domain_stops_no_other(processes: Processes) -> None:
    domain, other = processes.domain, processes.domain + 1
    with console(processes, domain, "--engine", "embedded") as embedded:
        code, _, err = processes.run("--engine", "ros2", "stop", env=environment(domain))
        assert (code, "and no robot is on domain" in err) == (3, True), err
        with (
            console(processes, domain, "--engine", "ros2") as ros,
            console(processes, other, "--engine", "ros2") as far,
        ):
            code, _, err = processes.run("--engine", "ros2", "stop", env=environment(domain))
            assert (code, err) == (0, "confirmed\n")
            code, _, err = processes.run("status", env=environment(domain))
            assert code == 3
            assert f"ARCHO /, ros2 domain {domain}" in err
            assert "ARCHO /, embedded" in err
            assert [stops(one) for one in (ros, far, embedded)] == [1, 0, 0]
