"""The pictures in README and docs: `python -m tests.screenshot screenshot.svg`.

The name of the file says which one: see PICTURES.
"""

from __future__ import annotations

import asyncio
import sys
import tempfile
from collections.abc import Awaitable, Callable
from pathlib import Path

from tests.recording import at_home

_BRISK = ("-p", "drain_min:=1.0", "-p", "drain_max:=1.6", "-p", "time_scale:=4.0")
_LAMP = """\
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


class Lamp(Node):
    def __init__(self):
        super().__init__("lamp")
        self.brightness = self.create_publisher(Float32, "brightness", 10)
        self.create_timer(0.5, self.on_timer)

    def on_timer(self):
        self.brightness.publish(Float32(data=0.8))
        self.get_logger().info("shining")


def main():
    rclpy.init()
    rclpy.spin(Lamp())
"""


async def overview() -> str:
    """Return the console a while after several shelves were typed."""
    from tests.support.console import console  # Not before the engine is chosen.

    async with console(*_BRISK, size=(160, 48)) as op:
        await op.press("g")
        await op.type("7 3 12 9")
        await op.press("enter")
        await op.until("MOVING to 12")
        await op.until("m left of")
        await op.press("escape")
        await op.until("m left of")
        return op.app.export_screenshot()


async def first_drive() -> str:
    """Return the console on the first drive, on its way to shelf 12."""
    from tests.support.console import console

    async with console("-p", "time_scale:=1.0", size=(100, 30), in_field=True) as op:
        await op.type("12")
        await op.press("enter")
        await op.until("MOVING to 12")
        await op.until(" 2 %")
        return op.app.export_screenshot()


async def replay() -> str:
    """Return the replay of a STOP."""
    from tests.replay.recorded import replay as replayed
    from tests.replay.recorded import written
    from tests.support.console import console

    async with console(*_BRISK) as op:
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.until("m left of")
        await op.press("ctrl+x")
        path = await written(op)
    async with replayed(path) as watcher:
        await watcher.press("m", "m", "m", "right")
        return watcher.app.export_screenshot()


async def own_nodes() -> str:
    """Return the console with a node of one's own, whose lines are among the events."""
    from tests.support.console import console

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "lamp.py"
        file.write_text(_LAMP)
        async with console(node_files=[file], size=(100, 30)) as op:
            await op.press("5")
            await op.until("shining   x 4")
            return op.app.export_screenshot()


PICTURES: dict[str, Callable[[], Awaitable[str]]] = {
    "screenshot.svg": overview,
    "first_drive.svg": first_drive,
    "replay.svg": replay,
    "own_nodes.svg": own_nodes,
}


def main() -> None:
    """Draw the picture that the file's name says."""
    path = Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as home:
        at_home(home)
        path.write_text(asyncio.run(_drawn(PICTURES[path.name])), encoding="utf-8")


async def _drawn(draw: Callable[[], Awaitable[str]]) -> str:
    return await draw()


if __name__ == "__main__":
    main()
