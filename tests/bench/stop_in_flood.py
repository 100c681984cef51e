"""STOP beside floods and a busy machine: `python -m tests.bench.stop_in_flood [KIND ...]`.

The console runs in a pseudo terminal, and ctrl+x is written to it 30 times, each time amid other
keys in one write. Prints how long each took to the callback of the robot's service, in ms.

KIND is `lines` (one node logs 10,000 lines a second, no two alike), `messages` (one publishes
10,000 readings a second) or `loops` (three other processes loop); all three when none is named.
The design asks for 100 ms at worst beside `lines` and `messages`, 300 beside `loops`, on two cores.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from archo_tui.keyed_app import HELD
from tests.support.terminal import Terminal

_PRESSES = 30
_BURST = "12\x1834"  # ctrl+x behind keys that lead to panels, and before others
_NODES = str(Path(__file__).with_name("stop_nodes.py"))
_LOOPS = 3
_BARS = {"lines": 100, "messages": 100, "loops": 300}  # ms at worst


def press(kind: str, heard: Path) -> list[float]:
    """Press STOP beside a flood; return how long each press took to the robot, in ms."""
    os.environ |= {"FLOOD": kind, "HEARD": str(heard)}
    heard.touch()
    loop = [sys.executable, "-c", "while True: pass"]
    loops = [subprocess.Popen(loop) for _ in range(_LOOPS if kind == "loops" else 0)]
    terminal, took = Terminal("--node", _NODES, "--no-remote", fresh=True), []
    try:
        terminal.until("IDLE")
        _read(terminal, 2.0)
        for number in range(_PRESSES):
            begin = time.monotonic()
            terminal.write(_BURST)
            while len(times := heard.read_text().splitlines()) <= number:
                terminal.read(0.001)
            took.append(1000 * (float(times[number]) - begin))
            _read(terminal, HELD + 0.1)  # the key is let go of
    finally:
        terminal.kill(9)
        terminal.exit_code()
        terminal.close()
        for process in loops:
            process.kill()
            process.wait()
    return took


def _read(terminal: Terminal, seconds: float) -> None:
    """Take what is drawn for so long."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        terminal.read(0.02)
        terminal.output = terminal.output[-1000:]


def main() -> None:
    """Run and print."""
    for kind in sys.argv[1:] or _BARS:
        with tempfile.TemporaryDirectory() as folder:
            took = press(kind, Path(folder, "heard"))
        said = f"median {statistics.median(took):.1f}, worst {max(took):.1f}"
        print(f"{kind}, ms: {said} (bar: {_BARS[kind]})", flush=True)


if __name__ == "__main__":
    main()
