"""What the console costs: `python -m tests.bench.console [WORDS]`; some five minutes for all rows.

Prints the rows that have one of the words in their name. CPU is that of one core, beside an empty
Textual app or `python -c pass` in the same run, medians of rounds that take turns. The rows of real
ROS 2 are there where its rclpy is installed. Run it on a quiet machine: the ratios are what counts.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import median

from tests.bench.process import Program, cpu, resident
from tests.support import chosen

ROUNDS = 5
REST = 4.0  # s after the start that are not measured
SPAN = 10.0  # s in which a load is measured
KEYS = 60
CANCELS = 15
WHOLE = 4000  # bytes: an update of more draws the whole screen
FAST = ("-p", "publish_period:=0.02")  # 50 Hz

EMPTY = """
from textual.app import App
from textual.widgets import Input
class Empty(App):
    def compose(self):
        yield Input("ready")
Empty().run()
sys.exit()
"""
CROWD = """
import threading
from archo_tui import engine
engine.activate("embedded", hosting=True)
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
context = rclpy.Context()
rclpy.init(context=context)
for part in range({executors}):
    executor = SingleThreadedExecutor(context=context)
    for number in range({nodes}):
        node = Node(f"crowd_{{part}}_{{number}}", context=context)
        for name in range({parameters}):
            node.declare_parameter(f"p{{name}}", name)
        executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
print("CROWD", flush=True)
"""
HANGING = """
from rclpy.node import Node
class Hanging(Node):
    def __init__(self):
        super().__init__("hanging")
        self.create_timer(0.5, self.hang)
    def hang(self):
        while True:
            pass
"""
# what of the start on real ROS 2 is rclpy's: its imports, the robot's nodes and one that hears them
ALONE = """
import rclpy
from archo_bringup import battery_monitor, dashboard, motor_controller
from archo_interfaces.msg import BatteryStatus
from rclpy.executors import SingleThreadedExecutor
rclpy.init(args=[])
heard = []
robot = battery_monitor.BatteryMonitor(), dashboard.Dashboard(), motor_controller.MotorController()
listener = rclpy.create_node("listener")
listener.create_subscription(BatteryStatus, "battery_level", heard.append, 10)
executor = SingleThreadedExecutor()
for node in (*robot, listener):
    executor.add_node(node)
while not heard:
    executor.spin_once()
print("heard", flush=True)
executor.spin()
sys.exit()
"""
ONLINE = "● online"
HERE = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def say(name: str, value: str, beside: str = "") -> None:
    """A row of the table."""
    print(f"{name:<44}{value:>16}   {beside}", flush=True)


def start(engine: str = "embedded") -> None:
    """CPU and bytes to the first frame that shows the robot."""
    ours, empty, alone, size, repaints = [], [], [], [], []
    for _ in range(ROUNDS + 1):
        with Program(code=EMPTY) as program:
            program.frame("ready")
            empty.append(cpu(program.terminal.pid))
        if engine == "ros2":
            with Program(code=ALONE) as program:
                program.until("heard")
                alone.append(cpu(program.terminal.pid))
        with Program(engine=engine) as program:
            program.frame(ONLINE)
            ours.append(cpu(program.terminal.pid))
            size.append(float(len(program.terminal.output)))
            repaints.append(sum(update > WHOLE for update in program.updates))
    del ours[0], empty[0], alone[:1]  # that compiled
    say(
        f"start, {engine}, CPU",
        f"{1000 * median(ours):.0f} ms",
        f"{_times(ours, empty)} an empty app",
    )
    if engine == "ros2":
        said = f"{_times(alone, empty)} an empty app"
        say("of it rclpy's own", f"{1000 * median(alone):.0f} ms", said)
    else:
        say(
            "start, bytes",
            f"{median(size) / 1000:.0f} kB",
            f"{median(repaints):.0f} whole repaints",
        )


def _times(ours: Sequence[float], others: Sequence[float]) -> str:
    return f"{median(ours) / median(others):.2f} x"


def commands() -> None:
    """CPU of what needs no screen."""
    took: dict[str, list[float]] = {}
    program = str(Path(sys.executable).with_name("archo-tui"))
    for _ in range(2 * ROUNDS):
        for words in ("-c pass", "--help", "--version", "journal"):
            command = [sys.executable if "pass" in words else program, *words.split()]
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            took.setdefault(words, []).append(used)
    for words, ours in list(took.items())[1:]:
        say(
            f"{words}, CPU",
            f"{1000 * median(ours):.0f} ms",
            f"{_times(ours, took['-c pass'])} python -c pass",
        )


def idle() -> None:
    """CPU with nothing to do but to show the robot."""
    with Program(code=EMPTY) as program:
        program.until("ready")
        program.read(REST)
        empty = program.load(SPAN)
    say("CPU of an empty Textual app", f"{empty:.2%}")
    for name, words, keys, size in (
        ("CPU at 1 Hz", (), "", (120, 36)),
        ("CPU at 1 Hz, 160 x 48 with the history", (), "", (160, 48)),
        ("CPU at 50 Hz", FAST, "", (120, 36)),
        ("CPU while a goal runs, 1 Hz", ("-p", "route_length:=1000.0"), "g12\r", (120, 36)),
    ):
        with Program("--ros-args", *words, size=size) as program:
            program.until(ONLINE)
            program.terminal.write(keys)
            program.read(REST)
            program.terminal.output = b""
            load = program.load(SPAN)
            say(name, f"{load:.2%}", f"{len(program.terminal.output) / SPAN:.0f} B/s")


@contextlib.contextmanager
def nodes(*words: str) -> Iterator[int]:
    """The robot on real ROS 2 in processes of their own; its domain."""
    domain = chosen.next_domain()
    environ = os.environ | HERE | {"ROS_DOMAIN_ID": str(domain)}
    running = [
        subprocess.Popen(
            [sys.executable, "-m", f"archo_bringup.{name}", "--ros-args", *words],
            env=environ,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for name in ("battery_monitor", "dashboard", "motor_controller")
    ]
    try:
        yield domain
    finally:
        for process in running:
            process.terminate()
            process.wait()


def attached() -> None:
    """CPU beside a robot of other processes."""
    for name, words in (("1 Hz", ()), ("50 Hz", FAST)):
        with nodes(*words) as domain:
            code = f"import os; os.environ |= {HERE | {'ROS_DOMAIN_ID': str(domain)}}"
            with Program("--attach", code=code, engine="ros2") as program:
                program.until(ONLINE)
                program.read(2 * REST)
                say(f"CPU attached, real ROS 2, {name}", f"{program.load(SPAN):.2%}")


def keys() -> None:
    """From a key to its effect."""
    with Program(code=EMPTY) as program:
        program.until("ready")
        empty = [program.press(letter, letter) for letter in "qwertyuiop" * (KEYS // 10)]
    with Program() as program:
        program.until(ONLINE)
        program.read(REST)
        typed = []
        for _ in range(KEYS // 2):
            program.terminal.write("g\x157")
            typed += [program.press("3", "73"), program.press("9", "739")]
        program.press("\x1b", "3 Go to")
        titles = {"2": "2 Motor", "5": "5 Nodes"}
        ours = [program.press(digit, titles[digit]) for digit in "25" * (KEYS // 2)]
    say(
        "a digit in the shelf's field, p50",
        f"{1000 * median(typed):.1f} ms",
        f"{_times(typed, empty)} a letter in an Input",
    )
    say(
        "a panel's digit, p50",
        f"{1000 * median(ours):.1f} ms",
        f"{_times(ours, empty)} a letter in an Input",
    )
    worst = max(ours)
    say("a panel's digit, worst", f"{1000 * worst:.1f} ms", f"{worst / max(empty):.2f} x")
    took = []
    with Program(
        "--ros-args", "-p", "route_length:=1000.0", "-p", "feedback_period:=0.05"
    ) as program:
        program.until(ONLINE)
        for _ in range(CANCELS):
            program.press("g\x1512\r", "m left of")
            took.append(program.press("\x03", "CANCELLED"))
    say(
        "ctrl+c to CANCELLED, p50",
        f"{1000 * median(took):.0f} ms",
        f"worst {1000 * max(took):.0f} ms",
    )


def hanging() -> None:
    """A dialog beside a node of the user's own whose callback never returns."""
    took: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "hanging.py")
        file.write_text(HANGING)
        for words in ((), ("--node", str(file))):
            with Program(*words) as program:
                program.until(ONLINE)
                program.read(REST)
                for _ in range(CANCELS):
                    took.setdefault(" ".join(words), []).append(
                        program.press("?", "type to search")
                    )
                    program.terminal.write("\x1bOP")  # the same key in a dialog: f1
    alone, beside = took.values()
    say(
        "help beside a node that hangs, p50",
        f"{1000 * median(beside):.0f} ms",
        f"{_times(beside, alone)} without it",
    )


def crowds() -> None:
    """A thousand nodes, and one with thousands of parameters."""
    for name, executors, each, parameters in (
        ("1,000 nodes with 20 parameters", 4, 250, 20),
        ("1 node with 5,000 parameters", 1, 1, 5000),
    ):
        code = CROWD.format(executors=executors, nodes=each, parameters=parameters)
        with Program(code=code) as program:
            program.until("CROWD")
            program.forget()
            first = program.frame(ONLINE)
            program.read(60 if each > 1 else 2 * REST)
            say(name, f"{program.load(SPAN):.2%}", f"{first:.1f} s to the first frame")


def memory() -> None:
    """Memory at 50 Hz; for longer runs see tests/bench/soak.py."""
    with Program("--ros-args", *FAST) as program:
        program.until(ONLINE)
        program.read(30)
        early = resident(program.terminal.pid)
        program.read(60)
        late = resident(program.terminal.pid)
    say("memory at 50 Hz", f"{late:.1f} MB", f"{late - early:+.1f} in 1 min")


def stop_in_a_flood() -> None:
    """STOP in 10,000 log lines a second; a process of its own, for the engine is chosen once."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.stop_in_flood", "lines"],
        capture_output=True,
        text=True,
        check=True,
    )
    say("STOP in a flood of 10 kHz", done.stdout.strip().removeprefix("lines, ms: "), "ms")


ROWS: dict[str, Callable[[], None]] = {
    "start": start,
    "commands": commands,
    "idle": idle,
    "keys": keys,
    "hanging": hanging,
    "stop": stop_in_a_flood,
    "crowds": crowds,
    "memory": memory,
}
ON_ROS: dict[str, Callable[[], None]] = {"start ros2": lambda: start("ros2"), "attached": attached}


def main() -> None:
    """Run and print."""
    rows = ROWS | (ON_ROS if importlib.util.find_spec("rclpy") else {})
    print(f"{time.strftime('%F')}, Python {sys.version.split()[0]}, {os.cpu_count()} cores, 120x36")
    with tempfile.TemporaryDirectory() as home:
        os.environ |= {"HOME": home, "XDG_STATE_HOME": home, "XDG_CONFIG_HOME": home}
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # the libraries are compiled, too
        for name, measure in rows.items():
            if not sys.argv[1:] or any(word in name for word in sys.argv[1:]):
                measure()


if __name__ == "__main__":
    main()
