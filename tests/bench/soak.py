"""Memory in a long run: `python -m tests.bench.soak [MINUTES]`, an hour if not said.

The console in a terminal of 120x36, telemetry at 50 Hz, one goal after the other by keys; between
them dialogs, the palette, other themes, other sizes and a shell's verbs. Prints the resident memory
every minute and what it grew by a minute behind the fifth (the bar: 200 kB).
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time

from tests.bench.process import resident
from tests.support.terminal import Terminal

_GOAL = 4.0  # s from one goal to the next
_SETTLED = 5  # minutes after which it is to grow no more
_OPENED = ("\x10go", "?", "A", "4\r", "5\r", "8\r", "6\r")  # each closed by escape
_SHELL = [sys.executable, "-m", "archo_tui", "status"]
_TELEMETRY = ("-p", "publish_period:=0.02", "-p", "feedback_period:=0.1", "-p", "drain_max:=0.05")


def run(minutes: float) -> list[tuple[float, int]]:
    """Operate the console for so long; (minutes, kB) once a minute."""
    terminal = Terminal("--ros-args", *_TELEMETRY)
    terminal.until("GOOD")
    begin = time.monotonic()
    samples: list[tuple[float, int]] = []
    for number in range(round(minutes * 60 / _GOAL)):
        terminal.output = b""
        terminal.write(f"g\x15{1 + number % 40}\r" if number % 10 else "c")
        end = begin + (number + 1) * _GOAL
        for opened in _OPENED:
            for keys in ("\x1b", opened, "\x1b"):
                terminal.write(keys)
                terminal.read(0.1)
        if number % 5 == 0:
            terminal.resize(100 + number % 60, 30 + number % 10)
            theme = ("nord", "gruvbox", "textual-dark")[number // 5 % 3]
            terminal.write(f"\x10{theme}\r")
            subprocess.run(_SHELL, capture_output=True, check=False)
        while time.monotonic() < end:
            terminal.read(0.05)
        passed = (time.monotonic() - begin) / 60
        if passed >= len(samples) + 1:
            samples.append((passed, round(1000 * resident(terminal.pid))))
            print(f"{passed:5.1f} min {samples[-1][1]:>8} kB", flush=True)
    terminal.kill(signal.SIGTERM)
    print(f"exit code {terminal.exit_code()}")
    return samples


def main() -> None:
    """Run and print."""
    minutes = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    with tempfile.TemporaryDirectory() as home:
        os.environ |= {"HOME": home, "XDG_STATE_HOME": home, "XDG_CONFIG_HOME": home}
        samples = run(minutes)
    settled = samples[_SETTLED:]
    if len(settled) > 1:
        grown = (settled[-1][1] - settled[0][1]) / (settled[-1][0] - settled[0][0])
        print(f"behind minute {_SETTLED}: {grown:.1f} kB a minute")


if __name__ == "__main__":
    main()
