"""`--record`: everything that is heard, in bags of ten minutes."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader
from std_msgs.msg import String

from archo_tui import cli
from archo_tui.base.errors import ArchoError
from archo_tui.base.paths import state_file
from archo_tui.recordings import store
from archo_tui.recordings.recorder import BlackBox
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.robot.node import serialize
from tests.support import warm
from tests.support.console import FAST
from tests.support.plain import operated
from tests.support.quiet import while_passes
from tests.support.stub import StandingClock
from tests.support.waiting import DEADLINE, wait_until

SLOW = ("-p", "publish_period:=1.0")


def box_to(path: Path, clock: StandingClock) -> BlackBox:
    attached = {"robot.yaml": "name: ARCHO"}
    folder = path.parent / "of events"
    return BlackBox(folder, clock, lambda *_: None, lambda: attached, record_all_to=path)


def say(box: BlackBox, text: object) -> None:
    box.receive("/said", String, serialize(String(data=str(text))))


@pytest.mark.waits
async def test_at_the_end_it_is_a_whole_bag(tmp_path: Path) -> None:
    path = tmp_path / "shift"
    async with operated(ros_args=(*FAST, *SLOW), record=path) as person:
        await person.enter("go 12", "ARRIVED")
        await while_passes(20.0)
        assert not (path / store.METADATA).exists()
    said = store.read_recording(path)
    assert said.why == "all of it"
    assert said.seconds > 20
    with AnyReader([path]) as reader:
        assert {"/battery_level", "/motor_status", "/archo_tui/state"} <= set(reader.topics)
    assert store.list_recordings(state_file("recordings")) == []


def test_every_ten_minutes_another_one_is_begun(tmp_path: Path) -> None:
    path, clock = tmp_path / "shift", StandingClock()
    box = box_to(path, clock)
    for second in range(700):
        clock.passed = float(second)
        say(box, second)
        box.tick()
        if second in (0, 1, 2, 602):  # What came is on the disk within a second in each part.
            part = path if second < 600 else tmp_path / "shift_2"
            wait_until(lambda: _count(part) >= (second + 1) % 541)  # noqa: B023
            assert BagFile(part).robot == "name: ARCHO"
    box.finish()
    assert box.close(DEADLINE) == ""
    first, second_bag = store.read_recording(path), store.read_recording(tmp_path / "shift_2")
    assert (first.seconds, second_bag.seconds) == (600.0, 158.0)
    assert second_bag.start == first.start + 541  # it begins with the minute before


@pytest.mark.parametrize("plain", [[], ["--plain"]])
def test_a_place_that_cannot_be_is_one_line(
    plain: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "there").mkdir()
    for name, said in (
        ("there", "it exists already: name another bag"),
        ("nowhere/bag", "nothing can be written to "),
        ("n" * 300, "File name too long"),
        ("", "--record .: it exists already"),  # not taken for none
    ):
        assert cli.main([*plain, "--record", name and str(tmp_path / name)]) == 2
        err = capsys.readouterr().err
        assert said in err
        assert err.count("\n") == 1


def test_it_fails_when_what_was_asked_for_is_not_written(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    command = warm.python("-m", "archo_tui", "--plain", "--record", str(folder / "shift"))
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as console:
        assert console.stdin
        assert console.stdout
        console.stdin.write("status\n")
        console.stdin.flush()
        assert console.stdout.readline()  # it has begun
        shutil.rmtree(folder)
        _, said = console.communicate(timeout=DEADLINE)
    assert "recording not written: No such file or directory" in said
    assert console.returncode == 1


@pytest.mark.posix
def test_a_console_that_is_killed_leaves_what_was_heard_until_then(tmp_path: Path) -> None:
    path = tmp_path / "shift"
    command = [sys.executable, "-m", "archo_tui", "--plain", "--record", str(path)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe) as console:
        assert console.stdin
        console.stdin.write(b"go 12\n")
        console.stdin.flush()
        assert console.stdout
        while b"accepted" not in console.stdout.readline():
            pass
        before = _count(path)
        wait_until(lambda: _count(path) > before)
        before = _count(path)
        wait_until(lambda: _count(path) > before)  # and with it all that came before that second
        os.kill(console.pid, signal.SIGKILL)
    assert not (path / store.METADATA).exists()
    done = subprocess.run(
        warm.python("-m", "archo_tui", "replay", "--text", str(path)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert "go to shelf 12: accepted" in done.stdout


def _count(path: Path) -> int:
    """How many messages are there by now; a file that was only just begun has none."""
    try:
        return BagFile(path).count
    except ArchoError:
        return 0


def test_below_the_floor_nothing_is_written_and_it_goes_on_when_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, clock, told = tmp_path / "shift", StandingClock(), list[tuple[str, str]]()
    box = box_to(path, clock)
    with monkeypatch.context() as patch:
        patch.setattr(store, "MIN_FREE", 10**18)
        say(box, "x")
        box.trigger("STOP", on_written=lambda *told_so: told.append(told_so))
        for clock.passed in (0.0, 6.0):
            box.tick()
            wait_until(lambda: "less than 1000000000000 MB are free" in box.trouble)
        wait_until(lambda: told)
    assert told[0][1].startswith("less than ")
    assert (list(tmp_path.glob("shift*")), store.list_recordings(tmp_path / "of events")) == (
        [],
        [],
    )
    clock.passed = 20.0
    box.trigger("STOP")
    box.tick()
    clock.passed = 26.0
    box.tick()
    wait_until(lambda: not box.trouble)
    box.finish()
    assert box.close(DEADLINE) == ""
    assert store.read_recording(path).messages == 1
