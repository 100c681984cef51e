"""Recordings made by a console, and the replay on a screen."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from archo_tui.base.paths import state_file
from archo_tui.recordings import store
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.recordings.replay.player import Player, load_robot_file
from archo_tui.recordings.replay.station import RecordedStation
from archo_tui.screen.app import ArchoApp
from archo_tui.screen.commands.replay import TimeLine
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.panel import Panel
from archo_tui.screen.widgets.rows import Rows
from tests.support import clock
from tests.support.console import Console, screen_text, send
from tests.support.quiet import Quiet, outside
from tests.support.stub import StandingClock, sized
from tests.support.waiting import DEADLINE, wait_until

_LINES = 4  # of a list that are compared: there may be room for more


async def written(op: Console) -> Path:
    """The recording, when the seconds behind its trigger have passed."""
    await op.at(clock.seconds() + 6.5)
    folder = state_file("recordings")
    await outside(lambda: store.list_recordings(folder) or op.session.box.failure, "a recording")
    return store.list_recordings(folder)[-1].folder


def shown(app: ArchoApp) -> dict[str, object]:
    """What header, banner and panels say: no keys, which a replay does not have."""
    found: dict[str, object] = {"banner": said(app.main.query_one("#banner", Line))}
    for panel in app.main.query(Panel):
        if isinstance(panel, TimeLine):
            continue
        found[f"title {panel.number}"] = str(panel.border_title)
        for line in panel.query(Line):
            if line.id and line.id not in ("goal-hint", "plots"):
                found[line.id] = re.sub(" +", " ", said(line))
        for rows in panel.query(Rows):
            lines = [rows.render_line(y).text.rstrip() for y in range(rows.size.height)]
            # Live, ages, paces (whose width cuts the names) and plots are up to a second old.
            lines = [re.sub(r"\d+\.\d( s|…| ?Hz)|(?<=…)\w+", "", line).rstrip() for line in lines]
            found[str(rows.id)] = [line for line in lines if line][:_LINES]
    return found


def said(line: Line) -> str:
    """Without what can be pressed there."""
    text = "" if line._content is None else line._content.plain
    pressed = r"   \(a.*| \(R releases\)|, then press R to release|   n continue   k skip"
    return re.sub(pressed, "", text.replace("recorded: ", "")).rstrip()


class Watcher:
    """Somebody in front of a replay."""

    def __init__(self, app: ArchoApp, player: Player, time: StandingClock, pilot: Any) -> None:
        self.app, self.player, self.time, self.pilot = app, player, time, pilot
        self._quiet = Quiet(app)

    async def press(self, *keys: str) -> None:
        for key in keys:
            self.time.passed += 1000.0 if not self.player.is_playing else 0.0  # no key is held
            send(self.app, key)
            await self.settle()

    async def settle(self) -> None:
        await self._quiet.settle()
        self.app.update_screen()
        await self._quiet.settle()

    async def show(self, time: float) -> None:
        """Jump there."""
        self.player.go_to(time)
        await self.settle()

    @property
    def text(self) -> str:
        return screen_text(self.app)


@asynccontextmanager
async def replay(path: Path, size: tuple[int, int] = (120, 36)) -> AsyncIterator[Watcher]:
    """The replay of a bag, read to its end."""
    time = StandingClock()
    bag = BagFile(path)
    player = Player(bag, load_robot_file(bag, ""), time)
    wait_until(lambda: player.is_complete)
    with sized(size):
        app = ArchoApp(RecordedStation(player, time), player=player)
    app.animation_level = "none"
    app.NOTIFICATION_TIMEOUT = DEADLINE  # type: ignore[misc]
    async with app.run_test(size=size) as pilot:
        watcher = Watcher(app, player, time, pilot)
        await watcher.settle()
        yield watcher
