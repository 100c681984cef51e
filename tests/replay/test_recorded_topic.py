"""A topic of a recording is shown at the position of the time line, as it was heard live."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from std_msgs.msg import Float32, UInt8MultiArray

from archo_tui.base.clock import Clock
from archo_tui.recordings.replay import bag as bag_reader
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.recordings.replay.player import Player
from archo_tui.recordings.replay.station import RecordedTopicFollower
from archo_tui.robot.topics.rows import TopicRequest, TopicView
from tests.replay.bags import START, written
from tests.support import clock
from tests.support.archo import ARCHO
from tests.support.quiet import until

REQUEST = TopicRequest(plotted=("data",), plot_columns=10)


def value(views: list[TopicView]) -> float:
    """The value in the newest view."""
    found: Any = views[-1].fields[0].value if views and views[-1].fields else -1.0
    return float(found)


@asynccontextmanager
async def following(
    path: Path, topic: str = "/count"
) -> AsyncIterator[tuple[Player, list[TopicView]]]:
    """A player of a bag, and the views of a topic so far."""
    time = clock.current or Clock()
    player, views = Player(BagFile(path), ARCHO, time), list[TopicView]()
    await until(lambda: player.is_complete)
    follower = RecordedTopicFollower(player, time, topic, lambda: REQUEST, views.append)
    task = asyncio.ensure_future(follower.run())
    try:
        yield player, views
    finally:
        task.cancel()


async def test_the_fields_are_those_at_the_position_also_while_it_plays(tmp_path: Path) -> None:
    sent = [("/count", Float32(data=float(number))) for number in range(1_000)]
    counts = written(tmp_path / "counts.mcap", sent)  # tenths of a second
    async with following(counts) as (player, views):
        for seconds, shown in ((0.05, 0.0), (90.05, 900.0), (30.05, 300.0), (30.25, 302.0)):
            player.go_to(START + seconds)
            await until(lambda shown=shown: value(views) == shown)  # type: ignore[misc]
        field = views[-1].fields[0]
        assert (field.least, field.greatest) == (0.0, 302.0)
        assert views[-1].rate == pytest.approx(10, rel=0.01)
        assert views[-1].age == pytest.approx(0.05, abs=0.01)
        assert views[-1].plots["data"][-1] is not None
        player.go_to(START + 10)
        player.play(on=True)
        del views[:]
        await until(lambda: value(views) > 150.0)
        assert len(views) > 10
    async with following(counts, "/other") as (_, views):
        await until(lambda: views)
        assert views[-1].fault == "it was not recorded"


async def test_of_too_many_bytes_those_around_the_position_are_read_and_open_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bag_reader, "MAX_BYTES", 20_000)
    sent = [("/image", UInt8MultiArray(data=bytes([number] * 1_000))) for number in range(200)]
    path = written(tmp_path / "images.mcap", sent)
    async with following(path, "/image") as (player, views):
        player.go_to(START + 15.05)
        await until(lambda: views and views[-1].fields)
        view = views[-1]
        row = next(row for row in view.fields if row.path == "data")
        assert row.first.startswith("96 96 ")
        assert view.with_elements is not None
        opened = view.with_elements(view, {"data": 700}).fields
        paths = [field.path for field in opened]
        assert next(path for path in paths if "data[" in path) == "data[700]"
        assert opened[paths.index("data[719]")].value == 0x96
