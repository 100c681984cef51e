"""The way up to the screen is bounded: a loop that stalled finds one snapshot, the newest."""

from __future__ import annotations

import asyncio
import threading

import pytest

from archo_tui.robot.runtime import Mailbox
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Snapshot

pytestmark = pytest.mark.pure


async def test_a_stalled_loop_gets_one_call_with_the_newest() -> None:
    door, got = Mailbox(), list[Snapshot]()
    door.open(got.append)

    def flood() -> None:
        for ticks in range(1000):
            door.put(Snapshot()._replace(motion=Motion(count=ticks)))

    thread = threading.Thread(target=flood)
    thread.start()
    thread.join()  # the loop stalls meanwhile, on purpose
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert [snapshot.motion.count for snapshot in got] == [999]
    door.put(Snapshot())
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert len(got) == 2
