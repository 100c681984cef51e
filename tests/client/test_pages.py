"""What the pages of programs show is what happens; recordings, answers and results as data."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import archo_tui
from archo_tui.base.paths import state_file
from archo_tui.client.protocol import EXITS
from archo_tui.recordings import recorder, store
from archo_tui.robot.outcome import data_of
from archo_tui.verbs import topics
from archo_tui.verbs.show import ShowHistory
from tests.robot.test_slow_services import Mapper
from tests.support import chosen, clock
from tests.support.console import FAST
from tests.support.plain import operated
from tests.support.robot import making
from tests.support.shells import heard, raw, served, typed
from tests.support.states import NORMAL
from tests.support.stub import StubRobot, stub_station
from tests.support.waiting import DEADLINE

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "protocol.md").read_text()
SHELL = (DOCS / "shell.md").read_text()
NAMED = {"VERSION": r"[\w.+]+", "PID": r"\d+", "NAME": r"\d+-[0-9a-f]{8}", "AGE": r"\d+\.\d+"}


def _block(language: str) -> str:
    found = re.search(rf"^```{language}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


@pytest.mark.real_time
@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="the hello of the page names the engine")
async def test_the_session_of_the_page_is_what_is_said_byte_by_byte() -> None:
    async with served(ros_args=FAST, domain_id=None):
        one = await raw()
        for line in _block("").splitlines():
            if line.startswith("> "):
                one.send(f"{line[2:]}\n".encode())
                continue
            said = await asyncio.wait_for(one.reader.readline(), DEADLINE)
            wanted = re.escape(line[2:])
            for name, pattern in NAMED.items():
                wanted = re.sub(rf"\b{name}\b", lambda _, p=pattern: p, wanted)  # type: ignore[misc]
            assert re.fullmatch(wanted, said.decode().removesuffix("\n")), (line, said)
        one.close()


@pytest.mark.real_time
def test_the_exit_codes_of_the_page_are_those_that_a_shell_ends_with() -> None:
    told: dict[str, int] = {}
    for code, words in re.findall(r"^\| (\d+) \|[^|]*\| (.*?) \|$", SHELL, re.MULTILINE):
        told |= {word: int(code) for word in re.findall(r"`(\w+)`", words)}
    assert told == EXITS


NETCAT = """\
import os, select, socket, sys
folder, name = os.path.split(sys.argv[2])
os.chdir(folder)  # its whole name may be too long
console = socket.socket(socket.AF_UNIX)
console.connect(name)
while True:
    for one in select.select([0, console], [], [])[0]:
        data = os.read(0, 65536) if one == 0 else console.recv(65536)
        if not data:
            sys.exit()
        console.sendall(data) if one == 0 else os.write(1, data)
"""


@pytest.mark.real_time
@pytest.mark.skipif(shutil.which("bash") is None, reason="the lines are bash's")
async def test_the_client_in_five_lines_of_shell_sends_the_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    netcat = tmp_path / "nc"  # what it does is all that is wanted of it
    Path(f"{netcat}.py").write_text(NETCAT)
    netcat.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$0.py" "$@"\n')
    netcat.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    lines = _block("bash")
    assert len(lines.splitlines()) == 5
    async with served(ros_args=FAST) as person:
        done = await asyncio.to_thread(
            subprocess.run, ["bash", "-c", lines], capture_output=True, text=True, timeout=DEADLINE
        )
        assert json.loads(done.stdout)["code"] == "arrived", done
        await heard(person, "Arrived at shelf 12")


EXAMPLES = re.findall(r"^```python\n(.*?)^```", (DOCS / "python.md").read_text(), re.M | re.S)
PRINTED = [
    ["8", "shelf 12 Arrived at shelf 12", "0.5"],
    ["shelf 7"],
    ["misuse Shelf: at most 40, not 99", "not yet"],
    [" Arrived at shelf 3"],  # by the log or the goal, whichever comes first
    ["\n8", "{'encoder_ticks': ", " Hz\n"],  # Some 5, and less on a busy machine.
]


@pytest.mark.real_time
@pytest.mark.parametrize(("code", "lines"), [*zip(EXAMPLES, PRINTED, strict=True)])
async def test_the_examples_in_python_do_what_they_say(
    code: str, lines: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(topics, "LISTEN", 2.0)
    code = code.replace("timeout=5", "timeout=1")

    def run() -> str:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(code, {})
        return out.getvalue()

    async with served(ros_args=FAST):
        said = await asyncio.to_thread(run)
    for line in lines:
        assert line in said


@pytest.mark.real_time
@pytest.mark.parametrize("line", ["keep", "wait battery 100"])
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


@pytest.mark.real_time
async def test_a_shell_prints_the_answer_and_a_program_gets_its_fields() -> None:
    made: list[Mapper] = []
    async with served(making(made, Mapper)):
        made[0].wake()
        said = await typed("call", "save_map")
        assert said == (0, "success true, message map.pgm\n", "")
        said = await typed("call", "save_map", "--json")
        assert json.loads(said.out)["data"] == {"success": True, "message": "map.pgm"}

        def call() -> Any:
            with archo_tui.connect() as robot:
                return robot.do("call", "save_map")

        assert await asyncio.to_thread(call) == {"success": True, "message": "map.pgm"}


@pytest.mark.real_time
async def test_the_result_of_any_goal_that_was_waited_for_is_data() -> None:
    pytest.importorskip("depot_interfaces")
    from tests.robots.rover import Counting

    async with served(Counting):
        said = await typed("send_goal", "fibonacci", "order=3", "--wait")
        assert (said.code, said.out) == (0, "sequence [0, 1, 1, 2]\n")
        said = await typed("send_goal", "fibonacci", "order=3", "--wait", "--json")
        last = json.loads(said.out.splitlines()[-1])
        assert last["data"]["result"] == {"sequence": [0, 1, 1, 2]}


@pytest.mark.real_time
async def test_a_time_that_is_over_says_that_it_may_still_be_done() -> None:
    async with served(Mapper):
        began = time.monotonic()
        said = await typed("call", "save_map", "--timeout", "0.5")
        assert time.monotonic() - began < 2.5  # s: nothing is called off, so nothing is waited for
        assert said.code == 4
        assert said.err == "archo-tui: call: not within 0.5 s: the robot may still do it\n"
