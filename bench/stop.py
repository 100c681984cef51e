"""How long STOP takes beside floods: `python -m bench.stop [FLOOD ...]`.

ctrl+x is written 30 times to the console's terminal, each time amid other keys in one write. Prints
the time to the callback of the robot's service, in ms, beside 10,000 log lines a second (`lines`),
as many readings (`messages`), three busy processes (`loops`), four programs that send as many
requests (`requests`), and 4,000 names on real ROS 2 (`names`), where that is installed.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

from archo_tui.client import sockets
from archo_tui.screen.keyed_app import HELD
from bench.process import Program

_PRESSES = 30
_BURST = "12\x1834"  # ctrl+x behind keys that lead to panels, and before others.
_NODES = str(Path(__file__).with_name("flooding_nodes.py"))
_HERE = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": "81"}
_WORST = {"lines": 100, "messages": 100, "loops": 300, "requests": 100, "names": 100}  # In ms.

LOOP = "while True: pass"
REQUESTS = """
import json, os, socket, sys, time
folder, name = os.path.split(sys.argv[1])
os.chdir(folder)
console = socket.socket(socket.AF_UNIX)
console.connect(name)
console.setblocking(False)
request = json.dumps({"id": 1, "words": ["status"]}).encode() + b"\\n"
rest = b""
while True:
    rest = rest or request * 100
    try:
        rest = rest[console.send(rest):]
        console.recv(1 << 20)
    except BlockingIOError:
        pass
    time.sleep(0.01)
"""
NAMES = """
import os, time
import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

def stop(request, response):
    with open(os.environ["HEARD"], "a") as file:
        file.write(f"{time.monotonic()}\\n")
    response.success = True
    return response

rclpy.init()
nodes = [rclpy.create_node(f"crowd_{number}") for number in range(200)]
executor = SingleThreadedExecutor()
for number, node in enumerate(nodes):
    for topic in range(12):
        node.create_publisher(Int32, f"topic_{number}_{topic}", 1)
    node.create_subscription(Int32, f"topic_{(number + 1) % len(nodes)}_0", print, 1)
    node.create_service(Trigger, f"service_{number}", lambda request, response: response)
nodes[0].create_service(Trigger, "emergency_stop", stop)
executor.add_node(nodes[0])
executor.spin()
"""


@contextlib.contextmanager
def running(code: str, count: int, *words: str) -> Iterator[None]:
    """Run Python code in so many processes of their own."""
    command = [sys.executable, "-c", code, *words]
    processes = [subprocess.Popen(command, stdout=subprocess.DEVNULL) for _ in range(count)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


@contextlib.contextmanager
def flooded(flood: str, robot: Path) -> Iterator[Program]:
    """Run the console beside a flood."""
    if flood == "names":
        robot.write_text("name: crowd\nstop: emergency_stop\n")
        code = f"import os; os.environ |= {_HERE}"
        words = "--attach", "--no-remote", "--robot", str(robot)
        with running(NAMES, 1), Program(*words, code=code, engine="ros2") as program:
            program.read(20.0)
            yield program
        return
    with Program("--node", _NODES) as program:
        program.until("IDLE")
        code, count = {"loops": (LOOP, 3), "requests": (REQUESTS, 4)}.get(flood, ("", 0))
        paths = sockets.socket_paths() if flood == "requests" else []
        with running(code, count, *paths):
            program.read(2.0)
            yield program


def press(flood: str, folder: Path) -> list[float]:
    """Press STOP beside a flood; return how long each press took to the robot, in ms."""
    heard, took = folder / "heard", []
    heard.touch()
    os.environ |= {"FLOOD": flood, "HEARD": str(heard), sockets.FOLDER_VARIABLE: str(folder)}
    with flooded(flood, folder / "robot.yaml") as program:
        for number in range(_PRESSES):
            began = time.monotonic()
            program.terminal.write(_BURST)
            while len(times := heard.read_text().splitlines()) <= number:
                program.terminal.read(0.001)
            took.append(1000 * (float(times[number]) - began))
            program.read(HELD + 0.1 + number / _PRESSES)  # The key is let go of.
            program.terminal.output = b""
    return took


def main() -> None:
    """Run and print."""
    real = importlib.util.find_spec("rclpy") is not None
    os.environ |= _HERE if real else {}
    for flood in sys.argv[1:] or [name for name in _WORST if real or name != "names"]:
        with tempfile.TemporaryDirectory() as folder:
            took = press(flood, Path(folder))
        worst = f"worst {max(took):.1f} (at most {_WORST[flood]})"
        print(f"{flood}: median {median(took):.1f} ms, {worst}", flush=True)


if __name__ == "__main__":
    main()
