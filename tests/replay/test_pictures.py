"""The replay as a picture. `--update-snapshots` accepts what is seen."""

from __future__ import annotations

from pathlib import Path

import pytest
from archo_interfaces.msg import BatteryStatus, MotorStatus
from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui.recordings.console import JOURNAL, STATE, to_json
from tests.replay.recorded import replay
from tests.support.bags import received, write
from tests.support.clock import TIME
from tests.support.front import differs, steady
from tests.support.night import corners
from tests.support.states import STATES
from tests.support.stub import StandingClock, stub_app

SIZES = {"80x24": (80, 24), "120x36": (120, 36), "160x48": (160, 48)}


@pytest.fixture(autouse=True)
def _steady(monkeypatch: pytest.MonkeyPatch) -> None:
    steady(monkeypatch)


def record(folder: Path) -> None:
    """A low battery on the way to a shelf, and what was done about it."""
    station = stub_app(STATES["battery low and moving"], StandingClock()).station
    station.on_snapshot(station.robot.snapshot)
    view = station.view
    said = to_json(view, view.time - view.now, with_events=True)
    messages: list[tuple[float, str, object]] = [(0.0, STATE, String(data=said))]
    for second in range(60):
        level = BatteryStatus(percentage=18.0 - second / 100, voltage=21.3)
        messages.append((second, "/battery_level", level))
        status = MotorStatus(encoder_ticks=15_420 + 100 * second, speed=0.8, moving=True)
        messages.append((second, "/motor_status", status))
    for second, text in ((12, "go to shelf 12: accepted"), (41, "cancel: accepted")):
        log = Log(level=20, name="console", msg=f"YOU: {text}")
        messages.append((second, JOURNAL, log))
    heard = [received(round((TIME + at) * 1e9), topic, one) for at, topic, one in messages]
    write(folder, sorted(heard, key=lambda one: one.time), {})


@pytest.mark.parametrize(
    ("size", "theme"),
    corners(
        [("80x24", "")],
        [
            *((size, "") for size in SIZES if size != "80x24"),
            *(("120x36", theme) for theme in ("textual-light", "high-contrast")),
        ],
    ),
)
async def test_a_replay_looks_as_accepted(
    request: pytest.FixtureRequest, size: str, theme: str, tmp_path: Path
) -> None:
    record(tmp_path)
    async with replay(tmp_path, SIZES[size]) as watcher:
        watcher.app.theme = theme or "textual-dark"
        await watcher.show(TIME + 20.5)
        name = " ".join(filter(None, ("replay", theme, size)))
        assert differs(request, name, watcher.app.export_screenshot(simplify=True)) == []


@pytest.mark.parametrize("size", corners([(120, 46)], [(160, 48), (200, 60)]))
async def test_the_time_line_takes_no_room_from_the_plots_on_a_large_screen(
    size: tuple[int, int], tmp_path: Path
) -> None:
    record(tmp_path)
    async with replay(tmp_path, size) as watcher:
        await watcher.show(TIME + 20.5)
        assert "remaining 9.0 m" in watcher.text
        assert "too small" not in watcher.text
