"""A recording on the screen: as it was shown live, and nothing that acts."""

from __future__ import annotations

from datetime import datetime
from math import floor
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("diagnostic_msgs")
pytest.importorskip("sensor_msgs")
pytest.importorskip("nav_msgs")

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from std_msgs.msg import String
from textual.widgets import Button

from archo_tui.recordings.replay.bag import BagFile
from archo_tui.screen.commands import registry
from archo_tui.screen.commands.base import NOT_TYPING
from archo_tui.screen.commands.palette import palette_choices
from archo_tui.screen.commands.replay import TimeLine
from archo_tui.screen.widgets.field import Field
from tests.replay.recorded import Watcher, replay, shown, written
from tests.robots.field import Base
from tests.support import chosen, clock
from tests.support.archo import ARCHO
from tests.support.console import BRISK, click, console, focused_panel
from tests.support.night import corners
from tests.support.stand_in import Made

FILE = Path(__file__).parents[1] / "robots" / "field.yaml"


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


class Raw(Node):
    """It publishes what the robot file only records."""

    def __init__(self, **options: Any) -> None:
        super().__init__("raw", **options)
        self._raw = self.create_publisher(String, "odom_raw", 10)
        self.create_timer(0.2, lambda: self._raw.publish(String(data="as it came")))


@pytest.mark.waits
async def test_pose_parts_and_recorded_topics_are_in_the_recording() -> None:
    made = Made(Base)
    async with console(robot=FILE, node_makers=[made, Raw], wait=False) as op:
        await op.until("x 1.2  y 0.4  90°  map")
        made.node.parts["base: left motor"] = (DiagnosticStatus.ERROR, "too hot")
        await op.until("ERROR base: left motor (sn 12): too hot")
        for _ in range(3):  # A wait has its deadline where time is real.
            await op.at(clock.seconds() + 22.0)
        # The pose was sent once, long before.
        await op.press("ctrl+x")
        await op.until("STOPPED")
        path = await written(op)
    bag = BagFile(path)
    async with replay(path) as watcher:
        watcher.app.before_suspend()  # As ctrl+z has it called.
        await watcher.show(watcher.player.end)
        assert "x 1.2  y 0.4  90°  map" in watcher.text
        assert "base: left motor" in watcher.text
        raw = list(bag.messages(watcher.player.start, watcher.player.end, {"/odom_raw"}))
        assert raw


def at(watcher: Watcher) -> float:
    """s since the begin of the recording."""
    return round(watcher.player.position - watcher.player.start, 3)


async def test_it_cannot_be_mistaken_for_the_robot_and_ends_at_once(drive: Path) -> None:
    async with replay(drive) as watcher:
        begin = datetime.fromtimestamp(watcher.player.start)
        assert f"REPLAY {begin:%Y-%m-%d %H:%M:%S}" in watcher.text
        assert not [one for one in watcher.app.main.query(Button) if one.region]
        assert not [one for one in watcher.app.main.query(Field) if one.region]
        for word in ("  Go  ", "Cancel", "STOP ", "r reset", "^x stop", "c charge"):
            assert word not in watcher.text
        await watcher.press("ctrl+x")
        assert "REPLAY: nothing was stopped" in watcher.text
        await watcher.press("ctrl+c")
        assert "Nothing is selected. Press q to quit." in watcher.text
        await watcher.press("m")
        await watcher.show(watcher.player.position + 0.5)  # The goal is sent by then.
        assert watcher.app.view.snapshot.running_goal is not None
        await watcher.press("q")
        assert watcher.app._exit


async def test_keys_clicks_and_marks_move_it(drive: Path) -> None:
    async with replay(drive) as watcher:
        assert at(watcher) == 0.0
        end = round(watcher.player.end - watcher.player.start, 3)
        for key, place in (
            *(("right", 1.0), ("right", 2.0), ("left", 1.0), ("left", 0.0), ("left", 0.0)),
            *(("end", end), ("shift+left", max(end - 10, 0.0)), ("home", 0.0)),
            ("shift+right", min(10.0, end)),
        ):
            await watcher.press(key)
            assert at(watcher) == place, key
        await watcher.press("home", "full_stop")
        first = at(watcher)
        await watcher.press("full_stop")
        assert at(watcher) > first
        await watcher.press("comma")
        assert at(watcher) == first
        await watcher.press("home")
        row = len(watcher.text.splitlines()) - 3
        line = watcher.text.splitlines()[row]
        begins, ends = line.index("●"), max(line.rindex(char) for char in "─┼" if char in line)
        for column, place in ((ends, end), (begins, 0.0)):
            click(watcher.app, column, row)
            await watcher.settle()
            assert at(watcher) == place
        said = []
        while "There is no mark after this moment." not in watcher.text:
            said.append(watcher.text.splitlines()[-2][18:].strip())
            await watcher.press("m")
        assert said[:3] == ["", "YOU: go to shelf 12: accepted", "GOAL: Arrived at shelf 12"]
        assert "YOU: STOP: confirmed" in ", ".join(said)
        assert "STOPPED: look for the cause" in ", ".join(said)
        for _ in said[1:]:
            assert "There is no mark before this moment." not in watcher.text
            await watcher.press("M")
        assert "There is no mark before this moment." in watcher.text


async def test_it_plays_at_its_speed_to_the_end_and_from_the_begin_again(drive: Path) -> None:
    async with replay(drive) as watcher:
        await watcher.press("space")
        end = round(watcher.player.end - watcher.player.start, 3)
        for keys, seconds, place, status in (
            ((), 2.0, 2.0, "▶ 1x"),
            (("right_curly_bracket", "right_curly_bracket"), 0.5, 4.0, "▶ 4x"),
            ((), 100.0, end, "‖ 4x"),
            (("space",), 0.0, 0.0, "▶ 4x"),
            (["left_curly_bracket"] * 9, 0.0, 0.0, "▶ 0.25x"),
        ):
            await watcher.press(*keys)
            watcher.time.passed += seconds
            await watcher.settle()
            assert at(watcher) == place
            assert status in watcher.text


async def test_every_command_only_shows_or_is_not_there(
    drive: Path,
) -> None:
    async with replay(drive) as watcher:
        there = {command.id for command in watcher.app.registry if command.is_listed}
        acts = {name for name, verb in watcher.app.verbs.items() if verb.acts}
        # STOP is another command here, and of what dialogs show nothing acts.
        shown = [c.id for c in registry(ARCHO) if acts & {*c.verbs} and c.id in there]
        assert shown == ["stop", "diagnostics", "details"]
        await watcher.press("R")
        assert "REPLAY: release was not sent: press q to leave the replay." in watcher.text
        await watcher.press("ctrl+p", *"reset")
        assert "Reset" not in watcher.text
        await watcher.show(watcher.player.end)
        assert watcher.app.view.snapshot.parameters
        titles = [choice.title for choice in palette_choices(watcher.app)]
        assert "Play, or pause" in titles
        assert not any(title.startswith("Set ") for title in titles)
        await watcher.press("escape", "f1")
        assert "To the next mark: an alarm, a command, the" in watcher.text
        await watcher.press("escape")
        await watcher.press("8", "home", "down", "enter")
        assert "/battery_level   archo_interfaces/msg/BatteryStatus" in watcher.text
        assert "percentage" in watcher.text
        assert "QoS not recorded" in watcher.text
        box, line = watcher.app.screen.query_one(".topic"), watcher.app.main.query_one(TimeLine)
        assert box.region.bottom == line.region.y  # It stays in sight.
        await watcher.press("t")
        assert "float32 voltage" in watcher.text
        await watcher.press("escape", "escape")
        assert "/battery_level   archo" not in watcher.text


async def test_each_panel_is_reached_by_its_number(drive: Path) -> None:
    async with replay(drive, (160, 48)) as watcher:
        for number in range(1, 10):
            await watcher.press(str(number))
            assert focused_panel(watcher.app) == number
        for command in watcher.app.registry:
            if command.where == NOT_TYPING and len(command.key) == 1 and command.key != "q":
                await watcher.press(command.key)
                await watcher.press("escape")
        assert watcher.app.is_running
