"""The console beside thousands of names on real ROS 2: `python -m tests.bench.large_graph`.

Prints its CPU at rest, of one core, and how long STOP takes from its key to the robot's service.
"""

from __future__ import annotations

import contextlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from tests.bench.process import Program

_CROWDS = {2000: (100, 12), 4000: (200, 12)}  # names: (nodes, topics each; 8 services each, too)
_SETTLED = 20.0  # s after the start that are not measured
_SPAN = 10.0  # s in which CPU is measured
_PRESSES = 20
_HELD = 1.0  # s until a key that is pressed again is another press
_HERE = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}

CROWD = """
import os, time
import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

def stop(request, response):
    with open(os.environ["HEARD"], "a") as file:
        file.write(f"{{time.monotonic()}}\\n")
    response.success = True
    return response

rclpy.init()
nodes = [rclpy.create_node(f"crowd_{{number}}") for number in range({nodes})]
executor = SingleThreadedExecutor()
for number, node in enumerate(nodes):
    for topic in range({topics}):
        node.create_publisher(Int32, f"topic_{{number}}_{{topic}}", 1)
    node.create_subscription(Int32, f"topic_{{(number + 1) % len(nodes)}}_0", print, 1)
    node.create_service(Trigger, f"service_{{number}}", lambda request, response: response)
nodes[0].create_service(Trigger, "emergency_stop", stop)
executor.add_node(nodes[0])
print("CROWD", flush=True)
executor.spin()
"""
ROBOT = "name: crowd\nstop: emergency_stop\n"


@contextlib.contextmanager
def crowd(nodes: int, topics: int, heard: Path, domain: int) -> Iterator[None]:
    """Run so many nodes in a process of their own."""
    environment = os.environ | _HERE | {"ROS_DOMAIN_ID": str(domain), "HEARD": str(heard)}
    code = CROWD.format(nodes=nodes, topics=topics)
    process = subprocess.Popen(
        [sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        process.stdout.readline()
        yield
    finally:
        process.kill()
        process.wait()


def measure(names: int, folder: Path, domain: int) -> tuple[float, list[float]]:
    """Return the part of a core that the console takes at rest, and the ms of each STOP."""
    heard, robot = folder / "heard", folder / "robot.yaml"
    heard.touch()
    robot.write_text(ROBOT)
    code = f"import os; os.environ |= {_HERE | {'ROS_DOMAIN_ID': str(domain)}}"
    with crowd(*_CROWDS[names], heard, domain):
        words = "--attach", "--no-remote", "--robot", str(robot)
        with Program(*words, code=code, engine="ros2") as program:
            program.read(_SETTLED)
            load, took = program.load(_SPAN), []
            for number in range(_PRESSES):
                began = time.monotonic()
                program.terminal.write("\x18")
                while len(times := heard.read_text().splitlines()) <= number:
                    program.terminal.read(0.001)
                took.append(1000 * (float(times[number]) - began))
                program.read(_HELD + 0.17 * number / _PRESSES)  # at any point of a second
            return load, took


def main() -> None:
    """Run and print."""
    for domain, names in enumerate(_CROWDS, start=81):
        with tempfile.TemporaryDirectory() as folder:
            load, took = measure(names, Path(folder), domain)
        stop = f"{statistics.median(took):.0f} ms, {max(took):.0f} at worst"
        print(f"{names} names: CPU at rest {load:.1%}; STOP {stop}", flush=True)


if __name__ == "__main__":
    main()
