"""Saves of a node's file at random moments of its moves: `python -m tests.bench.saves [ENGINE]`.

Two hundred, half of them broken. Prints the threads, descriptors and memory of the console after
each forty, and whether the last text that was saved still drives to a shelf.
"""

from __future__ import annotations

import os
import random
import sys
import tempfile
from pathlib import Path

from tests.bench.process import Program, resident

SAVES, EACH = 200, 40
ROBOT = ("-p", "route_length:=1000.0", "-p", "feedback_period:=0.1")
NODE = Path(__file__).parents[2] / "nodes" / "archo_bringup" / "motor_controller.py"
BROKEN = (
    "not Python\n",
    "import nothing_of_that_name\n",
    "raise ValueError('at import')\n",
)
RAISES = "class Broken(Node):\n    def __init__(self):\n        raise KeyError('at construction')\n"


def counted(pid: int) -> str:
    """Its threads, descriptors and memory."""
    threads, files = (len(os.listdir(f"/proc/{pid}/{kind}")) for kind in ("task", "fd"))
    return f"{threads:>3} threads {files:>3} descriptors {resident(pid):>6.1f} MB"


def run(engine: str, file: Path) -> None:
    """Save and save, while goals are sent."""
    text, choose = NODE.read_text(encoding="utf-8"), random.Random(4)
    file.write_text(text, encoding="utf-8")
    with Program("--node", str(file), "--ros-args", *ROBOT, engine=engine) as program:
        program.until("IDLE")
        program.read(2.0)
        print(f"{0:>4} saves {counted(program.terminal.pid)}", flush=True)
        for number in range(1, SAVES + 1):
            broken = choose.choice([*BROKEN, text + RAISES])
            saved = broken if number % 2 else f"{text}\n# {number}\n"
            file.write_text(saved, encoding="utf-8")
            program.read(choose.uniform(0.05, 1.2))
            program.terminal.write(f"g\x15{1 + number % 40}\r")
            program.read(choose.uniform(0.05, 0.6))
            if number % EACH == 0:
                program.forget()
                print(f"{number:>4} saves {counted(program.terminal.pid)}", flush=True)
        file.write_text(text, encoding="utf-8")
        program.read(5.0)
        program.forget()
        program.terminal.write("g\x157\r")
        program.until("m left of")
        program.terminal.write("\x03")
        program.until("CANCELLED")
        print(f"then a goal, cancelled: {counted(program.terminal.pid)}")


def main() -> None:
    """Run and print."""
    with tempfile.TemporaryDirectory() as home:
        os.environ |= {"HOME": home, "XDG_STATE_HOME": home, "XDG_CONFIG_HOME": home}
        run(sys.argv[1] if len(sys.argv) > 1 else "embedded", Path(home, "motor_controller.py"))


if __name__ == "__main__":
    main()
