"""Bags that this console did not write, and recordings that say nonsense."""

from __future__ import annotations

import json
import math
import re
import threading
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.msg import BatteryStatus, MotorStatus
from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui.recordings.bag import ReceivedMessage
from archo_tui.recordings.console import JOURNAL, STATE
from archo_tui.recordings.replay import bag as bag_reader
from archo_tui.recordings.replay.bag import BagFile, BagMessage
from archo_tui.recordings.replay.player import Player
from archo_tui.robot.state.events import Event
from tests.replay.recorded import replay
from tests.support.archo import ARCHO
from tests.support.bags import received, write
from tests.support.night import corners
from tests.support.stub import StandingClock
from tests.support.waiting import DEADLINE, wait_until

BEGIN = 1_700_000_000
HELD = 600  # messages of a slow bag that are read at once
EVENT = asdict(Event(BEGIN, "WARN", "motor", "hot", "", 2, BEGIN, 1))
GOAL = {
    "kind": {"id": "go", "title": "Go", "action": "move_to_shelf", "type": "x/action/Y"},
    "fields": {"shelf_number": 12},
    "phase": "MOVING",
    "sent": BEGIN,
    "time": BEGIN,
}


def drain(namespace: str = "", seconds: int = 60) -> list[ReceivedMessage]:
    """A battery that falls from 30 % by half a percent a second; a motor that stands."""
    heard = []
    for second in range(seconds):
        at = (BEGIN + second) * 10**9
        level = BatteryStatus(percentage=30.0 - second / 2, voltage=22.0)
        heard.append(received(at, f"{namespace}/battery_level", level))
        heard.append(
            received(at + 1, f"{namespace}/motor_status", MotorStatus(encoder_ticks=second))
        )
    name = f"{namespace.lstrip('/')}.dashboard".lstrip(".")
    heard.append(received((BEGIN + 30) * 10**9, "/rosout", Log(level=30, name=name, msg="Low")))
    return sorted(heard, key=lambda one: one.time)


@pytest.mark.parametrize("namespace", ["", "/hall/two"])
async def test_a_bag_of_the_robots_topics_is_shown_with_its_alarms(
    namespace: str, tmp_path: Path
) -> None:
    write(tmp_path, drain(namespace), {})
    async with replay(tmp_path / "recording_0.mcap") as watcher:
        await watcher.show(BEGIN + 10.5)
        assert "25.0 %" in watcher.text
        assert "10 ticks" in watcher.text
        assert "LOW BATTERY" not in watcher.text
        await watcher.show(BEGIN + 40.5)
        assert "LOW BATTERY 10.0 %: dock the robot" in watcher.text
        assert re.search(r"▲  \S*dashboard: ", watcher.text)
        low = BEGIN + 24.0  # below 20 % at 21, seen in the next second, and 2 s of it
        assert watcher.app.view.alarms[0].since == low
        await watcher.press("home", "m")
        assert watcher.player.position == low
        await watcher.press("left", "left", "left", "left")
        assert "LOW BATTERY" not in watcher.text


async def test_silence_is_lost_contact_from_its_begin_to_its_end_and_back(tmp_path: Path) -> None:
    late = received((BEGIN + 40) * 10**9, "/rosout", Log(level=20, name="dashboard", msg="Late"))
    write(tmp_path, [*drain(seconds=5), late], {})
    async with replay(tmp_path, (160, 48)) as watcher:
        for second, lost in ((20.0, "16 s"), (5.5, ""), (8.0, "4 s")):
            await watcher.show(BEGIN + second)
            assert ("CONTACT LOST" in watcher.text) == bool(lost)
            assert lost in watcher.text
            assert len(watcher.app.view.alarms) == bool(lost)
        # What only a console records is not there.
        assert watcher.text.count("-- none recorded") == 3  # nodes, graph, parameters
        assert "not recorded" in watcher.text.replace("-- none recorded", "")  # goals
        assert "waiting" not in watcher.text


class SlowBag(BagFile):
    """It stops in the midst of reading."""

    go_on = threading.Event()

    def messages(self, *given: Any) -> Iterator[BagMessage]:
        for number, said in enumerate(super().messages(*given)):
            if number == HELD:
                self.go_on.wait(DEADLINE)
            yield said


def test_of_what_is_not_read_yet_nothing_is_said(tmp_path: Path) -> None:
    write(tmp_path, drain(seconds=600), {})
    bag_file = SlowBag(tmp_path)
    player = Player(bag_file, ARCHO, StandingClock())
    player.go_to(BEGIN + 9.5)
    wait_until(lambda: not player.is_reading)
    assert player.view().snapshot.battery.percentage == 25.5
    player.go_to(BEGIN + 500.5)
    assert player.is_reading
    view = player.view()
    assert view.snapshot.battery.percentage is None
    assert view.alarms == ()
    bag_file.go_on.set()
    wait_until(lambda: not player.is_reading)
    assert player.view().snapshot.motion.count == 500


NONSENSE = [
    "{",
    json.dumps({"alarms": [{"name": "stopped", "text": "x", "since": math.nan}]}),
    json.dumps({"snapshot": {"goal": {**GOAL, "sent": 1e308}}}),
    json.dumps({"unknown": {"since": "tomorrow"}}),
]
BY_NIGHT = [
    *("", "[" * 100_000, "null", '"text"'),
    json.dumps({"snapshot": {"nodes": 7}}),
    json.dumps({"snapshot": {"goal": {"kind": "go"}}}),
    json.dumps({"hosted": [{"name": "/x", "life": "FLYING"}]}),
    json.dumps({"alarms": [{"name": "of another kind", "text": "x", "since": 1.0}]}),
    json.dumps({"alarms": [{"name": "stopped", "text": "x", "since": 1, "until": -1e18}]}),
    json.dumps({"snapshot": {"charge": [["a", "b"]]}}),
    json.dumps({"snapshot": {"message_rates": {"/t": {"heard": math.nan}}}}),
    json.dumps({"snapshot": {"open_stop": {"asked": math.inf}}}),
    json.dumps({"hosted": [{"name": "/x", "saved": 2**62}]}),
    json.dumps({"snapshot": {"events": [{**EVENT, "time": 1e308}]}}),
]


@pytest.mark.parametrize("said", corners(NONSENSE, BY_NIGHT))
async def test_a_state_that_says_nonsense_is_counted_and_the_rest_is_shown(
    said: str, tmp_path: Path
) -> None:
    odd: Any = received(BEGIN * 10**9 + 5, STATE, String(data=said))
    write(tmp_path, [*drain(), odd], {})
    async with replay(tmp_path) as watcher:
        await watcher.show(BEGIN + 10.5)
        assert "25.0 %" in watcher.text
        assert ("1 messages are unreadable" in watcher.text) == ("unknown" not in said)
        await watcher.show(BEGIN + 40.5)  # Without a state, alarms are looked for.
        assert ("LOW BATTERY 10.0 %" in watcher.text) == ("unknown" not in said)


async def test_no_text_changes_the_terminal_or_a_shell(tmp_path: Path) -> None:
    odd = {"snapshot": {"nodes": [{"name": "/evil\x1b]0;owned\x07"}], "namespace": "/"}}
    command = "ros2 topic list\nrm x\x1b[A"  # which a person may paste
    told = [
        received(BEGIN * 10**9, STATE, String(data=json.dumps(odd))),
        received(
            (BEGIN + 5) * 10**9,
            JOURNAL,
            Log(level=20, name="console", msg="YOU: moved", function=command),
        ),
    ]
    write(tmp_path, sorted([*drain(), *told], key=lambda one: one.time), {})
    async with replay(tmp_path) as watcher:
        await watcher.show(BEGIN + 10.5)
        assert "evil" in watcher.text
        assert "\x1b]0" not in watcher.text
        (event,) = (one for one in watcher.app.view.snapshot.events if one.level == "YOU")
        assert event.command.startswith("ros2 topic list")
        assert event.command.isprintable()


def test_an_hour_is_held_and_the_rest_is_read_when_it_is_asked_for(tmp_path: Path) -> None:
    hours = drain(seconds=600)
    for second in range(600):
        said = json.dumps({"snapshot": {"namespace": "/", "consoles": [f"anna_{second}"]}})
        hours.append(received((BEGIN + second) * 10**9 + 5, STATE, String(data=said)))
    hours += [one._replace(time=one.time + 7200 * 10**9) for one in drain(seconds=3)]
    write(tmp_path, sorted(hours, key=lambda one: one.time), {})
    player = Player(BagFile(tmp_path), ARCHO, StandingClock())
    wait_until(lambda: player.is_complete)
    for second in (599, 3, 250, 251, 0, 400):
        player.go_to(BEGIN + second + 0.5)
        assert player.snapshot().consoles == (f"anna_{second}",)
        assert player.snapshot().motion.count == second
    for place, charge in ((player.end, 29.0), (player.start, 30.0)):
        player.go_to(place)
        wait_until(lambda: not player.is_reading)
        assert player.snapshot().battery.percentage == charge


@pytest.mark.parametrize("limit", [("MAX_MESSAGES", 50), ("MAX_BYTES", 2000)])
def test_any_moment_of_a_bag_is_shown_however_dense_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit: tuple[str, int]
) -> None:
    monkeypatch.setattr(bag_reader, *limit)
    write(tmp_path, drain(seconds=3600), {})
    player = Player(BagFile(tmp_path), ARCHO, StandingClock())
    wait_until(lambda: not player.is_reading)
    player.go_to(player.start + 3000.0)
    wait_until(lambda: player.refresh() or player.snapshot().battery.received)  # type: ignore[func-returns-value]
    assert player.snapshot().motion.count == 3000


def test_it_plays_on_behind_the_hour_that_is_held_and_jumps_while_it_plays(tmp_path: Path) -> None:
    hours = [one for h in (0, 1, 2) for one in drain(seconds=60)]
    hours = [
        one._replace(time=one.time + (number // 121) * 3590 * 10**9)
        for number, one in enumerate(hours)
    ]
    write(tmp_path, hours, {})
    clock = StandingClock()
    player = Player(BagFile(tmp_path), ARCHO, clock)
    wait_until(lambda: player.is_complete)
    player.go_to(player.start + 3595.0)
    player.play(on=True)
    for _ in range(10):
        clock.passed += 1.0
        player.refresh()
        wait_until(lambda: not player.is_reading)
    assert player.position > player.start + 3600.0
    player.go_to(player.start + 7190.0)  # into what is not read yet
    player.refresh()
    assert player.position == player.start + 7190.0
    wait_until(lambda: not player.is_reading)
    assert player.snapshot().battery.percentage is not None
