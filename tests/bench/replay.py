"""What a replay of an hour at 10 Hz takes: `python -m tests.bench.replay`.

The time to its first picture and of a jump, beside the time that reading all of it takes.
"""

from __future__ import annotations

import random
import tempfile
import time
from pathlib import Path
from statistics import median

from archo_tui import engine

HOUR, RATE = 3600, 10  # s, messages a second
JUMPS = 200


def record(folder: Path) -> None:
    """Battery at 1 Hz, motion in between, a log line every 5 s."""
    from archo_interfaces.msg import BatteryStatus, MotorStatus
    from rcl_interfaces.msg import Log

    from tests.support.bags import received, write

    heard = []
    for number in range(HOUR * RATE):
        at = 1_700_000_000 * 10**9 + number * 10**9 // RATE
        if number % RATE == 0:
            level = BatteryStatus(percentage=90.0 - number / 1000, voltage=22.0)
            heard.append(received(at, "/battery_level", level))
        else:
            heard.append(received(at, "/motor_status", MotorStatus(encoder_ticks=number)))
        if number % (5 * RATE) == 0:
            said = Log(level=20, name="dashboard", msg="x" * (number % 300))
            heard.append(received(at, "/rosout", said))
    write(folder, heard, {})


def main() -> None:
    """Print the rows."""
    engine.activate("embedded")
    from archo_tui.clock import Clock
    from archo_tui.recordings.replay.bag import BagFile
    from archo_tui.recordings.replay.player import Player
    from archo_tui.robot_file import load

    with tempfile.TemporaryDirectory() as folder:
        record(Path(folder))
        begun = time.perf_counter()
        player = Player(BagFile(Path(folder)), load.load(load.default_path()), Clock())
        while player.is_reading:
            time.sleep(0.001)
        player.view()
        first = time.perf_counter() - begun
        while not player.is_complete:
            time.sleep(0.01)
        whole, took = time.perf_counter() - begun, []
        for _ in range(JUMPS):
            player.go_to(player.start + random.random() * HOUR)
            before = time.perf_counter()
            player.view()
            took.append(time.perf_counter() - before)
    print(f"an hour at 10 Hz, read whole        {whole:8.2f} s")
    print(f"to the first picture                {first:8.2f} s   {first / whole:.2f} of that")
    middle, worst = median(took) * 1e3, max(took) * 1e3
    print(f"a jump, without drawing it          {middle:8.1f} ms   {worst:.0f} ms at worst")


if __name__ == "__main__":
    main()
