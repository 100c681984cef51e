"""STOP in a flood of log lines: `python -m tests.bench.stop_in_flood`.

One node logs 10,000 lines a second, no two alike; ctrl+x is pressed 50 times. Prints how long each
press took to the node's callback, in ms: the design asks for 100 at worst, on a quiet machine.
"""

from __future__ import annotations

import asyncio
import statistics
import time
from typing import Any

from archo_tui import engine

engine.activate("embedded", hosting=True)

from archo_bringup.motor_controller import MotorController  # noqa: E402
from rclpy.node import Node  # noqa: E402

from archo_tui.app import ArchoApp  # noqa: E402
from archo_tui.keyed_app import HELD  # noqa: E402
from archo_tui.session import Options, Session  # noqa: E402
from tests.support.console import send  # noqa: E402

_PRESSES = 50
_RATE, _BURSTS = 10_000, 100  # lines and bursts a second


class Flood(Node):
    """Logs far too much."""

    def __init__(self, **options: Any) -> None:
        super().__init__("flood", **options)
        self.lines = 0
        self.create_timer(1 / _BURSTS, self._burst)

    def _burst(self) -> None:
        for _ in range(_RATE // _BURSTS):
            self.lines += 1
            letters = "".join(chr(97 + int(digit)) for digit in str(self.lines))
            self.get_logger().warning(f"line {letters}")


class Stopped(MotorController):
    """Notes when it is told to stop."""

    heard: list[float] = []

    def emergency_stop(self, request: Any, response: Any) -> Any:
        self.heard.append(time.perf_counter())
        return super().emergency_stop(request, response)


async def _press(session: Session) -> list[float]:
    app, took = ArchoApp(session.station), []
    async with app.run_test(size=(120, 36)):
        while len(app.view.snapshot.offered) < 4:
            await asyncio.sleep(0.1)
        await asyncio.sleep(2.0)
        for number in range(_PRESSES):
            begin = time.perf_counter()
            send(app, "ctrl+x")
            while len(Stopped.heard) <= number:
                await asyncio.sleep(0.001)
            took.append(1000 * (Stopped.heard[number] - begin))
            await asyncio.sleep(HELD + 0.1)  # the key is let go of
    return took


def main() -> None:
    """Run and print."""
    with Session(Options(node_makers=(Stopped, Flood))) as session:
        took = asyncio.run(_press(session))
        (flood,) = (h.node for h in session.host.nodes if isinstance(h.node, Flood))
        print(f"{flood.lines} lines; {len(took)} presses")
    print(f"ms: median {statistics.median(took):.1f}, worst {max(took):.1f}")


if __name__ == "__main__":
    main()
