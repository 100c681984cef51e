"""The picture in the README: `python -m tests.screenshot screenshot.svg`."""

from __future__ import annotations

import asyncio
import sys
import tempfile
from pathlib import Path

from tests.recording import at_home

ROBOT = ("-p", "drain_min:=1.0", "-p", "drain_max:=1.6", "-p", "time_scale:=4.0")


async def picture() -> str:
    """The console a while after several shelves were typed, as SVG."""
    from tests.support.console import console  # not before the engine is chosen

    async with console(*ROBOT, size=(160, 48)) as op:
        await op.press("g")
        await op.type("7 3 12 9")
        await op.press("enter")
        await op.until("MOVING to 12")
        await op.until("m left of")
        await op.press("escape", "left_square_bracket")
        await op.until("m left of")
        return op.app.export_screenshot()


def main() -> None:
    """Draw it."""
    with tempfile.TemporaryDirectory() as home:
        at_home(home)
        Path(sys.argv[1]).write_text(asyncio.run(picture()), encoding="utf-8")


if __name__ == "__main__":
    main()
