"""What the console costs beside an empty Textual app: `python -m bench.console [ENGINE]`.

The ratios are what counts, on a quiet machine; rounds take turns.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from bench.process import Program, cpu
from tests.support import chosen

ROUNDS = 5
REST = 4.0  # Seconds after the start that are not measured.
SPAN = 10.0  # Seconds in which a load is measured.
KEYS = 60

EMPTY = """
from textual.app import App
from textual.widgets import Input
class Empty(App):
    def compose(self):
        yield Input("ready")
Empty().run()
sys.exit()
"""
ONLINE = "● online"
MOVES = ("-p", "route_length:=1000.0")


def say(name: str, value: str, beside: str = "") -> None:
    """Print a row of the table."""
    print(f"{name:<40}{value:>12}   {beside}", flush=True)


def times(ours: Sequence[float], others: Sequence[float]) -> str:
    """Return how many times dearer ours are, in words."""
    return f"{median(ours) / median(others):.2f} x an empty app"


def start(engine: str) -> None:
    """Print the CPU and bytes to the first frame that shows the robot."""
    ours, empty, size = [], [], []
    for _ in range(ROUNDS + 1):
        with Program(code=EMPTY) as program:
            program.frame("ready")
            empty.append(cpu(program.terminal.pid))
        with Program(engine=engine) as program:
            program.frame(ONLINE)
            ours.append(cpu(program.terminal.pid))
            size.append(float(len(program.terminal.output)))
    del ours[0], empty[0]  # These compiled the libraries.
    say("start, CPU", f"{1000 * median(ours):.0f} ms", times(ours, empty))
    say("start, bytes", f"{median(size) / 1000:.0f} kB")


def loads(engine: str) -> None:
    """Print the CPU with nothing to do but to show the robot."""
    with Program(code=EMPTY) as program:
        program.until("ready")
        program.read(REST)
        say("CPU of an empty app", f"{program.load(SPAN):.2%}")
    for name, words, keys in (
        ("CPU at 1 Hz", (), ""),
        ("CPU at 50 Hz", ("-p", "publish_period:=0.02"), ""),
        ("CPU while a goal runs", MOVES, "g12\r"),
    ):
        with Program("--ros-args", *words, engine=engine) as program:
            program.until(ONLINE)
            program.terminal.write(keys)
            program.read(REST)
            program.terminal.output = b""
            load = program.load(SPAN)
            say(name, f"{load:.2%}", f"{len(program.terminal.output) / SPAN:.0f} B/s")


def keys(engine: str) -> None:
    """Print how long a key takes to its effect."""
    with Program(code=EMPTY) as program:
        program.until("ready")
        empty = [program.press(letter, letter) for letter in "qwertyuiop" * (KEYS // 10)]
    with Program(engine=engine) as program:
        program.until(ONLINE)
        program.read(REST)
        typed = []
        for _ in range(KEYS // 2):
            program.terminal.write("g\x157")
            typed += [program.press("3", "73"), program.press("9", "739")]
        program.press("\x1b", "3 Go to")
        titles = {"2": "2 Motor", "5": "5 Nodes"}
        panels = [program.press(digit, titles[digit]) for digit in "25" * (KEYS // 2)]
    for name, took in (("a digit in the shelf's field", typed), ("a panel's digit", panels)):
        say(name, f"{1000 * median(took):.1f} ms", times(took, empty))
    with Program("--ros-args", *MOVES, "-p", "feedback_period:=0.05", engine=engine) as program:
        program.until(ONLINE)
        took = []
        for _ in range(KEYS // 4):
            program.press("g\x1512\r", "m left of")
            took.append(program.press("\x03", "CANCELLED"))
    say("ctrl+c to CANCELLED", f"{1000 * median(took):.0f} ms", f"worst {1000 * max(took):.0f}")


def memory(engine: str) -> None:
    """Print what a minute and a half at 50 Hz leaves in memory."""

    def resident() -> float:
        status = Path(f"/proc/{program.terminal.pid}/status").read_text().splitlines()
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS")) / 1e3

    with Program("--ros-args", "-p", "publish_period:=0.02", engine=engine) as program:
        program.until(ONLINE)
        program.read(30)
        early = resident()
        program.read(60)
        say("memory at 50 Hz", f"{resident():.1f} MB", f"{resident() - early:+.1f} in a minute")


def main() -> None:
    """Run and print."""
    engine = sys.argv[1] if sys.argv[1:] else chosen.ENGINE
    with tempfile.TemporaryDirectory() as home:
        os.environ |= {"HOME": home, "XDG_STATE_HOME": home, "XDG_CONFIG_HOME": home}
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # The libraries are compiled, too.
        print(f"{time.strftime('%F')}, Python {sys.version.split()[0]}, {engine}, 120x36")
        for measure in (start, loads, keys, memory):
            measure(engine)


if __name__ == "__main__":
    main()
