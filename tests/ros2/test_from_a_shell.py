"""The command line on real ROS 2: verbs without and beside consoles, and what is refused."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.ros2.conftest import Processes
from tests.support.waiting import DEADLINE, wait_until

MOTOR, BATTERY = "archo_bringup.motor_controller", "archo_bringup.battery_monitor"
FAST = ("-p", "feedback_period:=0.05", "-p", "time_scale:=75.0")
SLOW = ("-p", "feedback_period:=0.1", "-p", "time_scale:=2.0")


def test_a_verb_attaches_acts_and_leaves(processes: Processes) -> None:
    processes.start(MOTOR, *FAST)
    processes.start(BATTERY, "-p", "publish_period:=0.1")
    assert processes.verb("go", "12", "--wait") == (0, "", "accepted\nArrived at shelf 12\n")
    code, out, _ = processes.verb("status", "--line")
    assert (code, out[:6]) == (0, "ARCHO ")
    beyond = processes.verb("go", "99", "--wait")
    assert beyond == (2, "", "archo-tui: go: Shelf: at most 40, not 99\n")
    assert processes.verb("stop") == (0, "", "confirmed\n")
    code, _, err = processes.verb("release")
    assert (code, "add --yes to do it" in err) == (2, True)


def test_ctrl_c_cancels_its_goal(processes: Processes) -> None:
    processes.start(MOTOR, *SLOW)
    drives = processes.begin("--engine", "ros2", "go", "12", "--wait")
    assert drives.stderr is not None
    assert drives.stderr.readline() == "accepted\n"
    drives.send_signal(signal.SIGINT)
    _, err = drives.communicate(timeout=DEADLINE)
    assert (drives.returncode, "Cancelled" in err) == (130, True)


DRIVEN = """
import rclpy
from geometry_msgs.msg import Twist
rclpy.init()
node = rclpy.create_node("driven")
node.create_subscription(Twist, "cmd_vel", lambda speed: print(speed.linear.x, flush=True), 10)
rclpy.spin(node)
"""


def test_ctrl_z_ends_what_it_publishes_with_no_speed(processes: Processes) -> None:
    words = "pub", "cmd_vel", "linear.x=0.5", "--rate", "20", "--yes"
    command = [sys.executable, "-c", DRIVEN]
    with subprocess.Popen(
        command, env=processes.environment, stdout=subprocess.PIPE, text=True
    ) as driven:
        speeds: list[float] = []
        hearing = threading.Thread(target=lambda: speeds.extend(map(float, driven.stdout or ())))
        hearing.start()
        try:
            drives = processes.begin("--engine", "ros2", *words)
            wait_until(lambda: len(speeds) >= 20 or drives.poll() is not None)
            if drives.poll() is not None:  # A pause of a busy machine has ended it.
                drives.communicate()
                speeds.clear()
                drives = processes.begin("--engine", "ros2", *words)
                wait_until(lambda: len(speeds) >= 20)
            assert speeds == [0.5] * len(speeds)
            drives.send_signal(signal.SIGTSTP)
            wait_until(lambda: speeds[-1] == 0.0)
            status = Path(f"/proc/{drives.pid}/status")
            # It stands still, or has ended: where no shell waits for it, SIGTSTP does nothing.
            wait_until(lambda: re.search("State:\t[TZ]", status.read_text()))
            drives.send_signal(signal.SIGCONT)
            _, err = drives.communicate(timeout=DEADLINE)
            assert (drives.returncode, "ended by a pause" in err) == (5, True)
        finally:
            drives.kill()
            driven.kill()
            hearing.join()


def test_without_a_robot_it_is_one_line(processes: Processes) -> None:
    where = f"on domain {processes.domain} (rmw_fastrtps_cpp, discovery LOCALHOST): "
    code, out, err = processes.verb("status")
    assert (code, out, len(err.splitlines())) == (3, "", 1)
    said = "archo-tui: no console runs here, and no robot is "
    assert err.startswith(f"{said}{where}for a robot elsewhere set ")


DOLLY = """version: 1
name: Dolly
motion: {topic: motor_status, types: {archo_interfaces/msg/MotorStatus: {moving: moving}}}
stop: {service: emergency_stop, release: release_emergency_stop}
commands:
  - {id: zero, title: Zero, service: reset_encoder}
"""


def test_a_robot_file_is_used_without_a_console(processes: Processes, tmp_path: Path) -> None:
    file = tmp_path / "dolly.yaml"
    file.write_text(DOLLY)
    processes.start(MOTOR, "-r", "__ns:=/d1")
    dolly = "--namespace", "/d1", "--robot", str(file)
    assert processes.verb(*dolly, "zero") == (0, "", "Encoder reset to zero\n")
    assert processes.verb(*dolly, "stop") == (0, "", "confirmed\n")
    code, out, err = processes.verb(*dolly, "status")
    assert (code, err) == (0, "")
    assert "motion IDLE\ngoal the robot file names no goal\n" in out
    assert processes.verb(*dolly, "zerro")[::2] == (2, NEAREST)
    code, out, _ = processes.verb("--robot", str(file), "zero", "--help")
    assert (code, out.splitlines()[0]) == (0, "zero: Zero")


NEAREST = "archo-tui: no command 'zerro' (nearest: zero)\n"


def test_a_wrong_namespace_is_answered_with_where_robots_are(processes: Processes) -> None:
    processes.start(MOTOR, "-r", "__ns:=/d1")
    seen = "robots seen: /d1; use --namespace /d1"
    for verb in ("status", "alarms", "stop"):
        code, out, err = processes.verb("--namespace", "/d2", verb)
        said = f"archo-tui: no console runs here, and no robot is in namespace /d2: {seen}\n"
        assert (code, out, err) == (3, "", said)
    code, out, _ = processes.verb("status")
    assert (code, out.splitlines()[0]) == (0, seen)
    assert processes.verb("alarms") == (0, f"no data yet: {seen}\n", "")


def test_a_console_that_starts_tells_of_a_stop_that_was_not_released(
    processes: Processes, tmp_path: Path
) -> None:
    file = tmp_path / "dolly.yaml"
    file.write_text(DOLLY)
    processes.start(MOTOR, "-r", "__ns:=/d1")
    words = "--engine", "ros2", "--attach", "--plain", "--namespace", "/d1", "--robot", str(file)
    environment = processes.environment | {"XDG_STATE_HOME": str(tmp_path)}

    def plain(typed: str) -> str:
        return processes.run(*words, typed=typed, env=environment)[1]

    assert "STOP: confirmed" in plain("stop\n")
    told = plain("alarms\nrelease --yes\n")
    assert "HAS NO RELEASE IN THE JOURNAL: the robot may still be stopped" in told
    assert "release stop: Released" in told  # nothing kept it from that
    # A busy machine may not have found the robot by then.
    wait_until(lambda: "No alarms" in plain("alarms\n"))


# Beside consoles of the other engine and of another domain.


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


# What a start refuses: one line, from whichever of ROS's layers it came.

TOO_FAST = "motor_controller:\n  ros__parameters:\n    max_speed: 9.0\n"
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
    (tmp_path / "fast.yaml").write_text(TOO_FAST)
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
