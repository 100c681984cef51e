"""A recording on the screen: as it was shown live, and nothing that acts."""

from __future__ import annotations

from math import floor

import pytest

from tests.replay.recorded import replay, shown, written
from tests.support import chosen, clock
from tests.support.console import BRISK, console
from tests.support.night import corners


@pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="in real time the robot moves on while it is looked at"
)
@pytest.mark.parametrize("size", corners([(120, 36)], [(80, 24), (160, 48)]))
async def test_at_each_moment_is_shown_what_was_shown_live(size: tuple[int, int]) -> None:
    # Two lines are below the panels; on a small screen the events have the row of the hidden form.
    more = 1 if size == (80, 24) else 2
    live: list[tuple[float, dict[str, object]]] = []
    async with console(*BRISK, size=size) as op:

        async def look() -> None:
            await op.at(floor(clock.seconds()) + 1.3)
            await op.session.robot.wait_for_events()  # else it may be up to a second old
            await op.settle()
            # A message of this very moment was recorded up to a microsecond later.
            live.append((op.session.station.clock.now() + 1e-6, shown(op.app)))
            await op.at(clock.seconds() + 0.05)

        await op.press("g", *"12", "enter")
        await op.until("MOVING to 12")
        await look()
        await op.until("✓ ARRIVED")
        await look()
        await op.press("g", *"7 8", "enter")
        await op.until("MOVING to 7")
        await op.press("ctrl+x")
        await op.until("✗ ABORTED")
        await op.until("STOPPED: look for the cause")
        await look()
        await op.press("a")
        await look()
        path = await written(op)
    width, height = size
    async with replay(path, (width, height + more)) as watcher:
        for time, before in live:
            await watcher.show(time)
            assert shown(watcher.app) == before
        for time, before in reversed(live):
            await watcher.show(time)
            assert shown(watcher.app) == before
