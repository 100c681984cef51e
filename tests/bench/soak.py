"""Memory in a long run: `python -m tests.bench.soak [MINUTES]`, an hour if not said.

The console in a terminal of 120x36, telemetry at 50 Hz, one goal after the other by keys. Prints
the resident memory every minute and what it grew by a minute in the second half.
"""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import time

from tests.bench.process import resident
from tests.support.terminal import Terminal

_GOAL = 4.0  # s from one goal to the next
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
    half = samples[len(samples) // 2 :]
    if len(half) > 1:
        grown = (half[-1][1] - half[0][1]) / (half[-1][0] - half[0][0])
        print(f"second half: {grown:.1f} kB a minute")


if __name__ == "__main__":
    main()
