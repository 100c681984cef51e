"""What programs are told: the recording that `keep` made, the hour as data, and one object."""

from __future__ import annotations

import asyncio
import json
import re
from typing import Any

import pytest

from archo_tui.base.paths import state_file
from archo_tui.recordings import recorder, store
from archo_tui.robot.outcome import data_of
from archo_tui.verbs.show import ShowHistory
from tests.support import clock
from tests.support.console import FAST
from tests.support.plain import operated
from tests.support.shells import said, served, typed
from tests.support.states import NORMAL
from tests.support.stub import StubRobot, stub_station


async def test_keep_names_its_recording_once_it_is_written_and_then_comes_the_next_line() -> None:
    async with operated(ros_args=FAST) as person:
        person.type("keep\nget motor_controller max_speed\n")
        await person.until("the last 60 s are recorded, and the next 5 s")
        assert await person.end() == 0
        (recording,) = store.list_recordings(state_file("recordings"))
        assert re.search(f"recorded {recording.name}\n(.*\n)*.* max_speed is", person.said)


@pytest.mark.real_time
@pytest.mark.parametrize("line", ["keep", "hz /motor_status", "wait battery 100"])
async def test_at_a_terminal_the_next_line_ends_what_takes_seconds(line: str) -> None:
    async with operated(ros_args=FAST, at_terminal=True) as person:
        person.type("status\n")
        await person.until("battery")
        began = clock.seconds()
        person.type(f"{line}\n")
        person.type("get motor_controller max_speed\n")
        await person.until("max_speed is")
        assert clock.seconds() - began < 2.0
        assert f"{line.split()[0]}: not waited for any longer\n" in person.said
        person.type("go 3\n")
        await person.until("go to shelf 3: accepted")
        assert await person.end() == 0


@pytest.mark.real_time
async def test_a_shell_waits_for_its_recording_and_is_told_the_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(recorder, "SECONDS_AFTER", 0.5)
    async with served() as person:
        began = clock.seconds()
        kept = await typed("keep", "--json")
        assert clock.seconds() - began >= recorder.SECONDS_AFTER
        (recording,) = store.list_recordings(state_file("recordings"))
        result = json.loads(kept.out)
        assert (kept.code, result["code"]) == (0, "done")
        assert result["data"] == {"recording": recording.name}
        assert result["text"] == f"recorded {recording.name}"
        given_up = await typed("keep", "--timeout", "0.2")
        assert (given_up.code, given_up.err) == (4, "archo-tui: keep: 0.2 s are over\n")
        state_file("recordings").rename(state_file("elsewhere"))
        state_file("recordings").write_text("a file where the folder would be")
        failed = await typed("keep")
        assert failed.code == 1
        assert failed.err.startswith("archo-tui: keep: recording not written: ")
        state_file("recordings").unlink()
        await person.end()


def test_history_is_data_with_the_age_of_each_reading() -> None:
    robot: Any = StubRobot(NORMAL)
    station = stub_station(robot)
    station.on_snapshot(NORMAL)
    told = json.loads(
        json.dumps(data_of(asyncio.run(ShowHistory().run(station, {}))), allow_nan=False)
    )
    charge = told["charge"]
    assert charge["unit"] == "%"
    assert [one["age"] for one in charge["readings"]] == [0.0, 60.0, 600.0, 3600.0]
    assert charge["readings"][0]["value"] == NORMAL.battery.percentage
    assert charge["readings"][-1]["value"] is None
    assert [goal["name"] for goal in told["goals"]] == [goal.name for goal in NORMAL.history]
    assert all("time" in goal and "phase" in goal for goal in told["goals"])


@pytest.mark.parametrize(
    ("words", "code", "exit_code"),
    [
        (("status", "--json"), "unreached", 3),
        (("stop", "--json"), "unreached", 3),
        (("statsu", "--json"), "misuse", 2),
        (("go", "12", "--line", "--json"), "misuse", 2),
    ],
)
def test_a_failure_is_one_object_also_without_a_console(
    words: tuple[str, ...], code: str, exit_code: int
) -> None:
    ended = said(*words)
    (line,) = ended.out.splitlines()
    assert json.loads(line)["code"] == code
    assert json.loads(line)["text"]
    assert (ended.code, ended.err) == (exit_code, "")
