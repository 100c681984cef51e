"""When the black box writes, what it calls that, and what becomes of a disk that fails."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from random import Random
from typing import Any

import pytest
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rosbags.highlevel import AnyReader

from archo_tui import cli
from archo_tui.base.paths import state_file
from archo_tui.recordings import bag, store
from archo_tui.recordings.store import Recording
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock
from tests.support.bags import add, received, write
from tests.support.console import FAST, LONG, console
from tests.support.night import corners
from tests.support.plain import Typed, typing
from tests.support.quiet import outside, until, while_passes


def found() -> list[Recording]:
    return store.list_recordings(state_file("recordings"))


@asynccontextmanager
async def operated(*args: str, makers: Sequence[Any] = ()) -> AsyncIterator[tuple[Typed, Session]]:
    """A console without a screen: what is recorded is the same."""
    options = Options(
        chosen.ENGINE, domain_id=chosen.next_domain(), ros_args=args, node_makers=makers
    )
    with Session(options, clock.current) as session:
        async with typing(session.station) as person:
            await until(lambda: makers or "emergency_stop" in session.robot.snapshot.offered)
            yield person, session


async def recorded(session: Session, count: int = 1) -> list[Recording]:
    """What is there when the seconds behind a trigger have passed, and the disk has it."""
    await while_passes(6.5)
    await outside(lambda: len(found()) >= count or session.box.failure, "a recording")
    return found()


async def stopped(person: Typed) -> None:
    await person.enter("stop", "STOP: confirmed")


def said(recording: Recording) -> list[str]:
    """The console's own lines in it."""
    with AnyReader([recording.folder]) as reader:
        topics = [c for c in reader.connections if c.topic == "/archo_tui/journal"]
        found: Any = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(topics)]
        return [one.msg for one in found]


async def test_a_stop_is_recorded_with_what_was_before_and_follows() -> None:
    async with operated(*FAST) as (person, session):
        await person.enter("go 12", "Arrived at shelf 12")
        await stopped(person)
        pressed = session.station.clock.now()
        (recording,) = await recorded(session)
        assert recording.name.endswith("_STOP")
        assert (recording.why, recording.kept) == ("STOP", False)
        assert "GOAL: Arrived at shelf 12" in said(recording)
        assert "YOU: STOP: confirmed" in said(recording)
        behind = recording.start + recording.seconds - pressed
        assert 3.9 < behind < 6.5
        wanted = f"recorded {recording.name}: STOP"  # which is said once it is written
        await until(lambda: wanted in [event.text for event in session.robot.snapshot.events])
        person.type("stop\n")  # of a robot that is stopped already
        assert [one.why for one in await recorded(session, 2)] == ["STOP", "STOP"]
        person.type("keep\n")
        kept = (await recorded(session, 3))[-1]
        assert (kept.why, kept.kept) == ("kept", True)


@pytest.mark.waits
async def test_no_cancel_is_recorded_and_what_follows_a_stop_is_with_it() -> None:
    async with operated(*LONG) as (person, session):
        await person.enter("go 12", "goal MOVING to 12")
        await person.enter("cancel", "CANCELLED")
        await while_passes(20.0)
        assert found() == []
        await person.enter("go 7", "goal MOVING to 7")
        await stopped(person)
        await person.until("ABORTED")
        (recording,) = await recorded(session)
    assert sorted(recording.why.split(", ")) == ["STOP", "shelf 7: aborted"]


class Crashing(Node):
    """Falls over after a second."""

    def __init__(self, **options: Any) -> None:
        super().__init__("crashing", **options)
        self.create_timer(1.0, lambda: 1 / 0)


async def test_a_crash_is_recorded() -> None:
    async with operated(makers=[Crashing]) as (person, session):
        await person.until("crashed: ")
        (recording,) = await recorded(session)
    assert recording.why == "node crashed /crashing"
    assert recording.name.endswith("_node_crashed_crashing")


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> tuple[threading.Event, threading.Event]:
    """A disk that says when it has begun to end a file, and goes on when it is told."""
    finish, began, goes_on = bag.BagWriter.finish, threading.Event(), threading.Event()

    def wait(*given: Any) -> None:
        began.set()
        assert goes_on.wait(30)
        finish(*given)

    monkeypatch.setattr(bag.BagWriter, "finish", wait)
    return began, goes_on


@pytest.mark.waits
async def test_what_happens_while_a_file_is_written_is_in_the_next_one(
    slow: tuple[threading.Event, threading.Event],
) -> None:
    began, goes_on = slow
    async with operated(*FAST) as (person, session):
        await stopped(person)
        await while_passes(6.5)
        await outside(began.is_set, "the disk")
        await person.enter("release --yes", "release stop: Released")
        person.type("stop\n")
        await until(lambda: session.robot.snapshot.is_stopped)
        goes_on.set()
        first, second = await recorded(session, 2)
    assert [first.why, second.why] == ["STOP", "STOP"]
    assert said(second).count("YOU: STOP: confirmed") == 2  # the first is in its last minute
    assert "YOU: release stop: Released; nothing resumes by itself" in said(second)


@pytest.mark.waits
async def test_a_disk_that_takes_nothing_is_an_alarm_and_ends_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "recordings")

    async with operated(*FAST) as (person, session):
        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", full)
            await stopped(person)
            assert await recorded(session) == []
        await person.enter("alarms", "RECORDING NOT WRITTEN: No space left on device: recordings")
        assert list(state_file("recordings").iterdir()) == []
        session.station.recorder.keep()
        await while_passes(6.5)
        await outside(found, "a recording")  # the failure before it stands until then
        (recording,) = found()
        await until(lambda: not session.box.trouble)
        assert recording.kept
        shutil.rmtree(state_file("recordings"))
        state_file("recordings").write_text("a file where the folder would be")
        await stopped(person)
        await while_passes(6.5)
        await outside(lambda: session.box.failure, "what the disk says")
        await person.enter("release --yes", "release stop: Released")  # The console goes on.
    assert session.unrecorded.startswith("recording not written: ")


def fill(folder: Path, kept: str = "no") -> None:
    (folder / "x_0.mcap").write_bytes(b"x" * 1000)
    write(folder, [], {"why": "a test", "kept": kept})


fill_kept = partial(fill, kept="yes")


def test_the_oldest_go_that_nobody_kept_when_room_is_needed(tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    for number in range(5):
        add(folder, 1000.0 + number, f"n{number}", fill_kept if number == 1 else fill)
    size = sum(one.bytes for one in store.list_recordings(folder)) // 5
    left, gone = store.make_room(folder, 3 * size + size // 2)
    assert [one.name[-2:] for one in gone] == ["n0", "n2"]
    assert [one.name[-2:] for one in store.list_recordings(folder)] == ["n1", "n3", "n4"]
    assert left == sum(one.bytes for one in store.list_recordings(folder))
    elsewhere = add(tmp_path / "elsewhere", 1000.0, "theirs", fill)
    (folder / "link").symlink_to(elsewhere)  # which is left alone
    assert len(store.list_recordings(folder)) == 3
    assert [one.name[-2:] for one in store.make_room(folder, 1)[1]] == ["n3"]
    assert elsewhere.exists()


def test_two_of_one_second_have_names_of_their_own(tmp_path: Path) -> None:
    names = [add(tmp_path / "r", 1000.0, "node crashed /a b", fill).name for _ in range(2)]
    assert names[1] == f"{names[0]}_2"
    assert names[0].endswith("_node_crashed_a_b")
    for path in (tmp_path / "r").rglob("*"):
        assert path.stat().st_mode & 0o077 == 0


_WRITES = """
import sys, pathlib
from archo_tui.ros import engine
engine.activate("embedded")
from archo_interfaces.msg import BatteryStatus
from tests.support.bags import add, received, write
charges = [BatteryStatus(percentage=float(n % 100)) for n in range(300)]
heard = [received(10**18 + n, "/battery_level", charge) for n, charge in enumerate(charges)]
while True:
    add(pathlib.Path(sys.argv[1]), 1000.0, "x", lambda f: write(f, heard, {"why": "x"}))
    print("written", flush=True)
"""


@pytest.mark.posix
def test_a_process_that_is_killed_leaves_whole_recordings_or_none(tmp_path: Path) -> None:
    folder, random = tmp_path / "recordings", Random(7)
    for _ in range(5):
        words = [sys.executable, "-c", _WRITES, str(folder)]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "written\n"
            time.sleep(random.uniform(0.0, 0.05))  # anywhere in the next one, or those behind it
            process.send_signal(signal.SIGKILL)
    whole = [path for path in folder.iterdir() if not path.name.startswith(".")]
    assert len(whole) == len(store.list_recordings(folder)) > 0
    for path in whole:
        with AnyReader([path]) as reader:
            assert reader.message_count == 300


Archo = Callable[..., tuple[int, str, str]]


@pytest.fixture
def archo(capsys: pytest.CaptureFixture[str]) -> Archo:
    """Runs the command line; returns its exit code, what it said, and its errors."""
    return lambda *words: (cli.main([*words]), *capsys.readouterr())


def test_the_list_says_when_why_how_long_and_how_large(archo: Archo) -> None:
    folder = state_file("recordings")
    folder.parent.mkdir(parents=True)
    assert archo("recordings") == (0, f"no recordings in {folder}\n", "")
    for at, what, made in ((1000.0, "STOP", fill), (2000.0, "kept", fill_kept)):
        add(folder, at, what, made)
    names = [one.name for one in store.list_recordings(folder)]
    code, out, _ = archo("recordings")
    assert code == 0
    assert sorted(line.split()[0] for line in out.splitlines()) == sorted(names)
    assert out.count("a test") == 2
    assert out.count(", kept") == 1
    code, out, _ = archo("recordings", "--json")
    found = [json.loads(line) for line in out.splitlines()]
    assert sorted(one["name"] for one in found) == sorted(names)
    assert {one["kept"] for one in found} == {False, True}
    deleted = archo("recordings", "--delete", names[0], names[0])
    assert deleted == (0, f"deleted {names[0]}\n", "")
    code, _, err = archo("recordings", "--delete", names[0], "../x")
    said = f"archo-tui: no recording is called {names[0]} (see archo-tui recordings)\n"
    assert (code, err) == (2, said)
    assert [one.name for one in store.list_recordings(folder)] == [names[1]]
    for size, said in ((212_400, "    212 kB"), (1_240_000, "    1.2 MB")):
        one = Recording(Path("a"), 0.0, 65.0, 9, "STOP", kept=False, bytes=size)
        assert store.length_size_and_why(one) == f"   65 s  {said}  STOP"


def test_what_cannot_be_is_one_line(archo: Archo) -> None:
    state_file("recordings").parent.mkdir(parents=True)
    state_file("recordings").write_text("")
    cases = [(["recordings"], "Not a directory"), (["recordings", "--delete", "x"], "Not a ")]
    for limit in ("0", "-1", "abc", "99999999999999999999", "1.5", ""):
        words = [f"--recordings-limit={limit}", "--plain"]
        cases.append((words, "is not 1 to 1000000 MB"))
    for words, said in cases:
        code, _, err = archo(*words)
        assert (code, err.count("\n")) == (2, 1)
        assert said in err


async def test_the_palette_lists_the_recordings_and_deletes_one() -> None:
    async with console(*FAST) as op:
        await op.press("ctrl+x")
        (recording,) = await recorded(op.session)
        await op.press("ctrl+p")
        await op.type("list recordings")
        await op.press("enter")
        await op.until("enter play")
        await op.press("y")
        await op.until(f"archo-tui replay {recording.name}")
        await op.press("d")
        await op.until(f"Delete {recording.name}? It is gone then.")
        await op.press("escape")
        assert found() == [recording]
        await op.press("d", "y")
        await op.until("No recordings.")
        assert found() == []
        await op.press("escape")
        await op.until(f"recording {recording.name} deleted")


TO_2248 = 225 * 365.25 * 86400.0  # Seconds from the tests' Unix time.


@pytest.mark.parametrize(
    ("before", "jump"),
    corners([(0.0, -3600.0)], [(0.0, 3600.0), (TO_2248, -TO_2248), (TO_2248, 0.0)]),
)
async def test_a_clock_that_is_set_behind_a_stop_makes_the_recording_no_longer(
    before: float, jump: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with operated(*FAST) as (person, session):
        kind, wrong = type(session.station.clock), [before]
        now = kind.now
        monkeypatch.setattr(kind, "now", lambda self: now(self) + wrong[0])
        await stopped(person)
        wrong[0] += jump
        at_end = session.station.clock.now()
        (recording,) = await recorded(session)
    assert recording.why == "STOP"
    assert 4.5 < recording.seconds < 66.5
    assert abs(recording.start - at_end) < 66.5
    assert "YOU: STOP: confirmed" in said(recording)


def test_the_one_just_written_stays_whatever_the_clock_says(tmp_path: Path) -> None:
    folder = tmp_path / "recordings"

    def numbered(made: Path) -> None:
        (made / "x_0.mcap").write_bytes(b"x" * 1000)
        about = {"why": "a test", "number": str(store.next_number(folder))}
        message = received(int(at * 1e9), "/rosout", Log())
        write(made, [message], about)

    kept = []
    for at, name in ((5000.0, "a"), (5001.0, "b"), (10.0, "c"), (11.0, "d")):  # the clock is reset
        made = add(folder, at, name, numbered)
        size = next(one.bytes for one in store.list_recordings(folder) if one.folder == made)
        store.make_room(folder, 2 * size + size // 2, made)
        kept.append("".join(one.name[-1] for one in store.list_recordings(folder)))
    assert kept == ["a", "ab", "bc", "cd"]
    foreign = tmp_path / "recordings" / "of_another_tool"  # with a date, and no number
    foreign.mkdir()
    write(foreign, [received(2 * 10**18, "/rosout", Log())], {})
    assert next(one.name for one in store.make_room(folder, 1, made)[1]) == "of_another_tool"
    assert [one.folder for one in store.list_recordings(folder)] == [made]


_SLOW = """
import time
from archo_tui.recordings import bag
bag.BagWriter.finish = lambda *_: time.sleep(60)
"""


@pytest.mark.posix
@pytest.mark.real_time
@pytest.mark.parametrize("way", corners(["keys", "a slow disk"], ["SIGTERM", "SIGHUP"]))
def test_a_stop_just_before_the_end_is_recorded_unless_the_disk_hangs(way: str) -> None:
    from tests.support.terminal import Terminal

    terminal = Terminal(code=_SLOW if way == "a slow disk" else "")
    terminal.until("● online")
    terminal.write("\x18")
    terminal.until("STOPPED")
    if way.startswith("SIG"):
        terminal.kill(signal.Signals[way])
    else:
        terminal.write("\x11")
    if way == "a slow disk":  # It holds the end up for a moment only.
        terminal.until("recording not written: the disk is too slow")
        assert terminal.exit_code() == 0
        assert not [p for p in state_file("recordings").iterdir() if not p.name.startswith(".")]
    else:
        terminal.exit_code()
        assert [one.why for one in found()] == ["STOP"]
