"""What the black box costs: `python -m tests.bench.black_box`, on a quiet machine.

Prints what the ring takes of the console's CPU while telemetry comes at 50 Hz, and how long a loop
that has nothing to do is held up while a minute of that is written, beside the same without.
"""

from __future__ import annotations

import asyncio
import tempfile
import threading
import time
from pathlib import Path
from statistics import median

from archo_tui import engine

engine.activate("embedded")

from archo_interfaces.msg import BatteryStatus, MotorStatus  # noqa: E402
from rcl_interfaces.msg import Log  # noqa: E402

from archo_tui.recordings.ring import ReceivedMessage, Ring  # noqa: E402
from tests.bench.process import Program  # noqa: E402
from tests.support.bags import add, received, write  # noqa: E402

RATE = 50  # Hz, of each of three topics
SECONDS = 60
MESSAGES = (
    ("/battery_level", BatteryStatus(percentage=80.0, voltage=24.0, battery_health="good")),
    ("/motor_status", MotorStatus(moving=True)),
    ("/rosout", Log(name="motor_controller", msg="a line as the robot writes it")),
)


def minute() -> list[ReceivedMessage]:
    """What is heard in a minute."""
    step = 10**9 // RATE
    times = range(10**18, 10**18 + SECONDS * 10**9, step)
    return [received(at, topic, message) for at in times for topic, message in MESSAGES]


def ring_share(heard: list[ReceivedMessage], span: float = 10.0) -> float:
    """The ring's part of the CPU that the console takes at 50 Hz."""
    costs = []
    for _ in range(5):
        ring, began = Ring(), time.process_time()
        for one in heard:
            ring.add(one)
        costs.append((time.process_time() - began) / SECONDS)
    with Program("--ros-args", "-p", "publish_period:=0.02") as console:
        console.read(5.0)
        return median(costs) / console.load(span)


async def held_up(writes: bool, heard: list[ReceivedMessage], folder: Path) -> float:
    """The worst delay, in ms, of a loop that sleeps for a millisecond again and again."""
    over = threading.Event()

    def fill(made: Path) -> None:
        write(made, heard, {})

    def run() -> None:
        try:
            if writes:
                add(folder, time.time(), "bench", fill)
            else:
                time.sleep(0.5)
        finally:
            over.set()

    threading.Thread(target=run).start()
    worst = 0.0
    while not over.is_set():
        began = time.perf_counter()
        await asyncio.sleep(0.001)
        worst = max(worst, time.perf_counter() - began - 0.001)
    return worst * 1e3


def main() -> None:
    """Print the rows."""
    heard = minute()
    print(f"the ring at {RATE} Hz: {ring_share(heard):.1%} of the console's CPU")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "recordings"
        asyncio.run(held_up(True, heard[:10], folder))  # imports
        for writes, what in ((False, "nothing is written"), (True, f"{len(heard)} are written")):
            worst = [asyncio.run(held_up(writes, heard, folder)) for _ in range(5)]
            print(
                f"a loop while {what}: held up for {median(worst):.1f} ms, {max(worst):.1f} worst"
            )


if __name__ == "__main__":
    main()
