"""A recording played over the live console, which goes on; only STOP reaches the robot."""

from __future__ import annotations

import asyncio
import gc
import shutil
import threading
from collections.abc import Iterator
from contextlib import AbstractAsyncContextManager
from itertools import cycle
from pathlib import Path
from typing import Any
from weakref import WeakSet

import pytest

from archo_tui.commands import lists
from archo_tui.commands.base import IN_PANEL
from archo_tui.daemon_threads import in_daemon
from archo_tui.paths import state_file
from archo_tui.recordings.replay.bag import BagFile, BagMessage
from archo_tui.recordings.replay.player import Player
from archo_tui.recordings.replay.station import RecordedStation
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screens.replay import ReplayScreen
from tests.replay.recorded import written
from tests.support import clock
from tests.support.console import BRISK, LONG, Console, click, console
from tests.support.quiet import outside

_recording: list[Path] = []  # The one of this process, which all tests play.


@pytest.fixture(autouse=True)
async def _recorded(tmp_path_factory: pytest.TempPathFactory, _time: None) -> None:
    """Put a recording of a robot that was stopped and released where the console keeps its own."""
    if _recording:
        shutil.copytree(_recording[0], state_file("recordings") / _recording[0].name)
        return
    async with console(*BRISK) as op:
        await op.press("ctrl+x")
        await op.until("STOPPED: look for the cause")
        await op.at(clock.seconds() + 3.0)
        await op.press("R", "y")
        await op.until(lambda: not op.app.view.snapshot.is_at_rest)
        made = await written(op)
    _recording.append(tmp_path_factory.mktemp("recorded") / made.name)
    shutil.copytree(made, _recording[0])


def recorded(
    *ros_args: str, size: tuple[int, int] = (120, 36)
) -> AbstractAsyncContextManager[Console]:
    """The console of a robot that has been recorded."""
    return console(*(ros_args or BRISK), size=size)


async def list_recordings(op: Console) -> None:
    await op.press("ctrl+p")
    await op.type("list the recordings")
    await op.press("enter")
    await op.until("enter play")


async def play(op: Console) -> None:
    """Choose the newest recording in the list of the palette."""
    await list_recordings(op)
    await op.press("enter")
    await op.until("REPLAY 20")


def live_line(op: Console) -> str:
    return op.text.splitlines()[0]


async def test_enter_plays_a_recording_and_q_leads_back_again_and_again() -> None:
    async with recorded() as op:
        before = clock.seconds()
        await play(op)
        assert live_line(op).startswith(" LIVE   ARCHO   ● online")
        assert "q Live robot" in op.text.splitlines()[-1]
        await op.press("m", "right")
        assert "recorded: ▲ STOPPED" in op.text
        assert "STOPPED" not in live_line(op)
        live = {c.key: c.id for c in op.app.registry if c.key and c.where != IN_PANEL}
        here = {command.key: command.id for command in op.app.front.registry}
        assert {key for key in here if live.get(key, here[key]) != here[key]} <= {"ctrl+c"}
        await op.at(before + 3.0)
        await op.press("q")
        assert op.app.screen is op.app.main
        assert "REPLAY" not in op.text
        received = op.app.view.snapshot.battery.received
        assert received is not None
        assert clock.seconds() - received < 2.0

        for _ in range(2):
            await play(op)
            await op.press("ctrl+p")
            await op.type("recordings")
            assert "List the recordings" not in op.text
            await op.press("escape", "q")
            assert op.app.screen is op.app.main

        op.app.show_message("something to read")
        await op.until("something to read")
        await play(op)
        op.app.clear_notifications()
        await op.press("q")
        assert op.app.replay is None
        assert "something to read" not in op.text

        await play(op)
        op.send("q", "q", "q")
        await op.settle()
        assert op.app.screen is op.app.main
        assert op.app.is_running
        assert not op.app._exit

        await play(op)
        op.app.report_failure(Outcome(Code.REFUSED, "not now, says the node"))
        await op.until("not now, says the node")
        assert op.line("✗ Live robot: not now")
        assert op.app.replay is not None
        op.app.replay.report_failure(Outcome(Code.REFUSED, "not in the recording"))
        await op.until("not in the recording")
        assert op.line("· Replay: not in")


async def test_a_node_and_its_topic_are_those_of_the_recording() -> None:
    async with recorded() as op:
        await play(op)
        await op.press("end", "5", "home", "down", "down", "enter")
        await op.until("topics published")
        await op.press("enter")
        await op.until("Topics of motor_controller")
        await op.press("down", "enter")
        await op.until("QoS not recorded")
        await op.until(lambda: "m/s" in op.line("speed"))
        await op.press("escape")
        await op.until("topics published")
        await op.press("tab", "enter")
        assert "log level of" not in op.text


async def test_stop_in_a_replay_stops_the_live_robot() -> None:
    async with recorded(*LONG) as op:
        await op.press("g", *"12", "enter")
        await op.until("MOVING to 12")
        await play(op)
        assert "MOVING to 12" in live_line(op)
        await op.press("home", "ctrl+x")
        await op.until(lambda: op.app.view.snapshot.is_at_rest)
        await op.until(lambda: "STOPPED" in live_line(op))
        assert "STOP goes to the live robot, not to the replay" in op.text
        assert isinstance(op.app.screen, ReplayScreen)
        await op.press("ctrl+p", "ctrl+x")
        assert "STOPPED" in live_line(op)


async def test_a_message_over_a_topic_of_a_replay_leaves_the_time_line_in_sight() -> None:
    async with recorded() as op:
        await play(op)
        await op.press("end", "8", "down", "enter")
        await op.until("QoS not recorded")
        before = op.text.splitlines()[-3:]
        await op.press("ctrl+x")
        await op.until("STOP goes to the live robot")
        assert op.text.splitlines()[-3:] == before


async def test_no_other_key_of_a_replay_reaches_the_live_robot() -> None:
    async with recorded(*LONG) as op:
        await op.press("g", *"12 7", "enter")
        await op.until("MOVING to 12")
        await play(op)
        for key in (
            "ctrl+c",
            "c",
            "r",
            "R",
            "k",
            "n",
            "a",
            "u",
            "s",
            "plus",
            "g",
            "enter",
            "ctrl+z",
        ):
            await op.press(key)
        await op.press("4", "enter", "space", "ctrl+o", "5", "s", "3", "tab", "enter")
        assert isinstance(op.app.screen, ReplayScreen)
        await op.press("q")
        snapshot, view = op.app.view.snapshot, op.app.view
        assert snapshot.running_goal is not None
        assert snapshot.running_goal.name == "shelf 12"
        assert view.waiting == ("7",)
        assert "MOVING to 12" in op.text


@pytest.mark.parametrize(("key", "verb"), [("R", "release"), ("g", "go"), ("c", "charge")])
async def test_a_key_of_the_robot_says_in_a_replay_that_nothing_was_sent(
    key: str, verb: str
) -> None:
    async with recorded() as op:
        await play(op)
        await op.press(key)
        await op.until(f"REPLAY: {verb} was not sent: press q for the live robot")
        assert op.app.station.robot.snapshot.events[-1].level != "YOU"
        await op.press("q")
        assert "REPLAY" not in op.text


async def test_the_stop_button_that_a_replay_covers_cannot_be_clicked() -> None:
    async with recorded(size=(160, 48)) as op:
        button = op.app.main.query_one("#stop").region
        await play(op)
        for key in ("9", "A"):  # Then a dialog, which leaves free where the button is.
            await op.press(key)
            click(op.app, button.x + 2, button.y)
            await op.at(clock.seconds() + 1.0)
            assert not op.app.view.snapshot.is_at_rest


async def test_the_footer_of_a_replay_stops_the_live_robot_when_it_is_clicked() -> None:
    async with recorded() as op:
        await play(op)
        footer = op.text.splitlines()[-1]
        click(op.app, footer.index("STOP live"), 35)
        await op.until(lambda: op.app.view.snapshot.is_at_rest)


async def test_the_live_console_has_the_size_of_a_terminal_that_changed_in_a_replay() -> None:
    async with recorded() as op:
        await play(op)
        await op.pilot.resize_terminal(80, 24)
        await op.until(lambda: op.app.screen.size.width == 80)
        await op.press("q")
        assert op.app.screen is op.app.main
        await op.until(lambda: len(op.text.splitlines()) == 24)
        assert "q Quit" in op.text.splitlines()[-1]


@pytest.mark.night
async def test_recordings_that_were_played_do_not_stay_in_memory() -> None:
    async with recorded() as op:
        players: WeakSet[Player] = WeakSet()
        for _ in range(4):
            await play(op)
            assert op.app.replay is not None
            station = op.app.replay.station
            assert isinstance(station, RecordedStation)
            players.add(station.player)
            del station
            await op.press("q")

        def kept() -> int:
            gc.collect()
            return len(players)

        # Of the last one, Textual may still hold something.
        await op.until(lambda: kept() <= 1)


async def test_a_long_recording_is_read_no_further_once_its_replay_was_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with recorded() as op:
        read = BagFile.messages

        def read_for_ever(*arguments: Any) -> Iterator[BagMessage]:
            return cycle([*read(*arguments)])

        monkeypatch.setattr(BagFile, "messages", read_for_ever)
        await play(op)
        assert "replay" in [thread.name for thread in threading.enumerate()]
        await op.press("q")
        await outside(
            lambda: "replay" not in [thread.name for thread in threading.enumerate()], "an end"
        )


async def test_ctrl_q_in_a_dialog_of_a_replay_asks_at_the_live_robot() -> None:
    async with recorded(*LONG) as op:
        await op.press("g", *"12", "enter")
        await op.until("MOVING to 12")
        await play(op)
        await op.press("question_mark", "ctrl+q")
        await op.until("The robot is on its way to shelf 12")
        assert "REPLAY" not in op.text
        await op.press("escape")
        assert op.app.screen is op.app.main


async def test_no_replay_opens_over_a_dialog_that_was_opened_after_enter(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    is_read = asyncio.Event()

    async def slow(work: Any, *arguments: Any) -> Any:
        if work is lists._open:
            await is_read.wait()
        return await in_daemon(work, *arguments)

    monkeypatch.setattr(lists, "in_daemon", slow)
    async with recorded() as op:
        for _ in range(2):  # The second list lies over the first.
            await list_recordings(op)
            await op.press("enter")
        is_read.set()
        await op.until("REPLAY 20")
        assert "not played: another dialog was opened meanwhile" in op.text
        await op.press("q")
        await op.until("enter play")
        await op.press("escape")
        assert op.app.screen is op.app.main


async def test_a_damaged_recording_gives_one_line_and_the_console_goes_on() -> None:
    async with recorded() as op:
        for file in Path(op.session.box._folder).glob("*/*.mcap"):
            file.write_bytes(b"no bag")
        await op.press("ctrl+p")
        await op.type("list the recordings")
        await op.press("enter")
        await op.until("enter play")
        await op.press("enter")
        await op.until("not played: ")
        await op.press("escape")
        assert op.app.screen is op.app.main


async def test_a_small_terminal_shows_the_live_robot_over_its_replay() -> None:
    async with recorded(size=(50, 15)) as op:
        await play(op)
        assert "LIVE" in live_line(op)
        assert "● online" in live_line(op)
        assert "q back" in live_line(op)
        assert "REPLAY 20" in op.text.splitlines()[1]
