"""The journal: every command, alarm and warning, line by line, whatever the disk does."""

from __future__ import annotations

import fcntl
import json
import os
import resource
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from archo_tui.base.paths import journal_file
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.station import journal
from archo_tui.station.journal import Journal, unreleased_stop
from tests.support.archo import SHELF
from tests.support.console import FAST, LONG, console
from tests.support.plain import operated
from tests.support.quiet import ended, until
from tests.support.waiting import wait_until

RESET = "archo_interfaces/srv/ResetEncoder"


def entries(file: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def test_an_entry_is_one_line_that_only_its_user_reads(
    tmp_path: Path,
) -> None:
    file = tmp_path / "new" / "journal.jsonl"
    file.parent.mkdir(0o700)
    file.touch(0o600)
    file.write_text('{"v": 1, "ki')  # a line that was left broken is ended first
    kept = Journal(file)
    kept.write(1_700_000_000.5, "command", text="two\nlines \x1b[2J ü", level="YOU")
    wait_until(lambda: file.read_text().endswith("}\n"))  # before it is closed
    entry = json.loads(file.read_text().splitlines()[1])
    assert entry["time"] == "2023-11-14T22:13:20.500+00:00"
    assert (entry["kind"], entry["text"]) == ("command", "two\nlines \x1b[2J ü")
    assert entry["user"]
    assert entry["v"] == 1
    kept.close()
    kept = Journal(tmp_path / "other" / "journal.jsonl")
    kept._lost = 7  # as many did not find room, which is told once
    for number in range(3):
        kept.write(0, "event", number=number)
    kept.close()
    made = tmp_path / "other" / "journal.jsonl"
    assert [entry.get("lost_before") for entry in entries(made)] == [7, None, None]
    assert (made.stat().st_mode & 0o777, made.parent.stat().st_mode & 0o777) == (0o600, 0o700)


def locked(path: Path) -> Callable[[], None]:
    other = path.open("w")
    fcntl.flock(other, fcntl.LOCK_EX)
    return other.close


def made_a_folder(path: Path) -> Callable[[], None]:
    path.mkdir()
    return path.rmdir


def piped(path: Path) -> Callable[[], None]:
    os.mkfifo(path)
    return path.unlink


@pytest.mark.parametrize(
    ("name", "hinder", "said"),
    [
        ("journal.lock", locked, "held by another process"),
        ("journal.jsonl", made_a_folder, "Is a directory"),
        ("journal.jsonl", piped, "not a regular file"),
        ("journal.lock", piped, "not a regular file"),
    ],
)
def test_what_stands_in_its_way_is_a_failure_while_it_does(
    tmp_path: Path, name: str, hinder: Callable[[Path], Callable[[], None]], said: str
) -> None:
    file = tmp_path / "journal.jsonl"
    end = hinder(tmp_path / name)
    kept = Journal(file)
    for number in range(1, 3):  # It is tried again with each.
        kept.write(0, "event", text="lost")
        wait_until(lambda number=number: kept.failure and kept._lost == number)  # type: ignore[misc]
    assert kept.failure == f"{said}: {tmp_path / name}"
    end()
    kept.write(0, "event", text="kept")
    kept.close()
    assert kept.failure == ""
    assert [(e["text"], e["lost_before"]) for e in entries(file)] == [("kept", 2)]


def test_a_disk_that_hangs_holds_nobody_up(tmp_path: Path) -> None:
    kept = Journal(tmp_path / "journal.jsonl")
    go_on = threading.Event()
    append = kept._append

    def hang(line: str) -> None:
        go_on.wait(10)
        append(line)

    kept._append = hang  # type: ignore[method-assign]
    for number in range(3000):
        kept.write(0, "event", number=number)
    go_on.set()
    wait_until(kept._entries.empty)
    kept.write(0, "event", number="last")
    kept.close()
    last = entries(tmp_path / "journal.jsonl")[-1]
    assert last["number"] == "last"
    assert sum(e.get("lost_before", 0) for e in entries(tmp_path / "journal.jsonl")) >= 1900


async def test_commands_alarms_warnings_and_the_ends_of_goals_are_in_it(unlimited: Path) -> None:
    async with operated(robot=unlimited, ros_args=LONG) as person:
        for line, said in (
            ("reset\ngo 99", "failed: go: shelf 99"),
            ("charge", "charge: "),
            ("discharge", "discharge: "),
            ("go 9", "goal MOVING to 9"),
            ("cancel", "goal CANCELLED"),
            ("go 7", "goal MOVING to 7"),
            ("stop", "alarm unacknowledged: STOPPED"),
            ("ack", "acknowledged: stopped"),
        ):
            await person.enter(line, said)
        await person.until("goal ABORTED")
        robot: Any = person.station.robot
        assert (await ended(robot.release_emergency_stop())).ok
        assert not (await ended(robot.cancel_all())).ok
        assert (await ended(robot.call("/reset_encoder", RESET, {}))).ok
        other = replace(SHELF, title="other")  # as it is made without a robot file
        assert not (await ended(robot.send(other, {"shelf_number": 41}))).ok
        assert (await ended(robot.set_parameters("/motor_controller", {"max_speed": 0.5}))).ok
        record = AuditRecord("save", {"path": "a.yaml"}, Code.DONE)
        robot.note("YOU", "console", "saved", audit_record=record)
        await person.until("saved")
    every = entries(journal_file())
    said_there = [(e["kind"], e.get("text", "")) for e in every]
    assert ("command", "reset encoder: Encoder reset to zero") in said_there
    assert ("command", "go to shelf 99: shelf 99 is not in 1 .. 40") in said_there
    assert ("event", "Goal refused: shelf 99 is not in 1 .. 40") in said_there
    states = [e["state"] for e in every if e["kind"] == "alarm" and e["name"] == "stopped"]
    assert states[:2] == ["unacknowledged", "acknowledged"]
    lines = [e["command"] for e in every if "command" in e]
    assert lines[0].startswith("ros2 service call /reset_encoder ")
    found = [entry for entry in every if "verb" in entry]
    commands, goals = (
        [(e["verb"], e["arguments"], e["code"]) for e in found if e["kind"] == kind]
        for kind in ("command", "goal")
    )
    max_speed = {"node": "/motor_controller", "values": {"max_speed": 0.5}}
    assert commands == [
        ("reset", {}, "done"),
        ("go", {"shelf_number": 99}, "refused"),
        ("charge", {}, "done"),
        ("discharge", {}, "done"),
        ("go", {"shelf_number": 9}, "accepted"),
        ("cancel", {}, "accepted"),
        ("go", {"shelf_number": 7}, "accepted"),
        ("stop", {}, "done"),
        ("release", {}, "done"),
        ("cancel", {"all": True}, "refused"),
        ("call", {"service": "/reset_encoder", "values": {}}, "done"),
        ("send_goal", {"action": "/move_to_shelf", "values": {"shelf_number": 41}}, "refused"),
        ("set", max_speed, "done"),
        ("save", {"path": "a.yaml"}, "done"),
    ]
    assert goals == [
        ("go", {"shelf_number": 9}, "cancelled"),
        ("go", {"shelf_number": 7}, "aborted"),
    ]


async def test_a_journal_that_cannot_be_written_is_said_on_the_screen() -> None:
    journal_file().mkdir(parents=True)
    async with console(*FAST) as op:
        await op.press("r")
        await op.until("● JOURNAL NOT WRITTEN: Is a directory: /")
        await op.press("g", "7", "enter")
        await op.until("Arrived at shelf 7")
        journal_file().rmdir()
        await op.press("r")
        await op.until("was: JOURNAL NOT WRITTEN, since ")


async def test_of_what_repeats_the_first_and_round_numbers_are_written() -> None:
    joints = ["Joint 1 overheated", "Joint 2 overheated"]
    async with operated(ros_args=FAST) as person:
        robot = person._plain._station.robot
        for _ in range(25):
            robot.note("WARN", "console", "again")
        for text in joints:
            robot.note("ERROR", "arm", text)
        for number in range(2001):
            robot.note("WARN", "queue", f"{number} wait")
        await until(lambda: any(e.text == "2000 wait" for e in robot.snapshot.events))
    found = entries(journal_file())
    assert [e["count"] for e in found if e.get("text") == "again"] == [1, 10]
    assert [e["text"] for e in found if e.get("source") == "arm"] == joints
    texts = [e["text"] for e in found if e.get("source") == "queue"]
    assert texts == [*(f"{number} wait" for number in range(100)), "999 wait", "1999 wait"]


def test_a_full_disk_leaves_no_half_line(tmp_path: Path) -> None:
    file = tmp_path / "journal.jsonl"
    file.write_text("{}\n")
    descriptor = os.open(file, os.O_RDWR | os.O_APPEND)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        with pytest.raises(OSError):
            journal._write_line(descriptor, b"x" * 500 + b"\n")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        os.close(descriptor)
    assert file.read_text() == "{}\n"


_WRITER = """
import sys
from pathlib import Path
from archo_tui.station import journal
journal.MAX_BYTES = 2000
kept = journal.Journal(Path(sys.argv[1]))
for number in range(300):
    kept._append('{"writer": "%s", "number": %d}' % (sys.argv[2], number))
kept.close()
"""


def test_two_consoles_that_rotate_at_once_lose_nothing_of_the_last_two_files(
    tmp_path: Path,
) -> None:
    file = tmp_path / "journal.jsonl"
    writers = [
        subprocess.Popen([sys.executable, "-c", _WRITER, str(file), name]) for name in ("a", "b")
    ]
    assert [writer.wait(60) for writer in writers] == [0, 0]
    old = file.with_name("journal.jsonl.1")
    assert 2000 < old.stat().st_size < 2100  # a full one, never one that was just begun
    assert file.stat().st_size < 2100
    lines = [json.loads(line) for path in (old, file) for line in path.read_text().splitlines()]
    for name in ("a", "b"):
        numbers = [line["number"] for line in lines if line["writer"] == name]
        assert numbers == list(range(300))[300 - len(numbers) :]


PLACE = {"file": "/r.yaml", "namespace": "/tb1", "engine": "ros2", "domain": 0}


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        ([], None),
        ([(100.0, "stop", Code.DONE, PLACE)], 100.0),
        ([(100.0, "stop", Code.DONE, PLACE), (110.0, "release", Code.DONE, PLACE)], None),
        ([(100.0, "stop", Code.DONE, PLACE), (110.0, "release", Code.TIMEOUT, PLACE)], 100.0),
        ([(100.0, "stop", Code.TIMEOUT, PLACE)], None),
        ([(100.0, "stop", Code.DONE, {**PLACE, "namespace": "/tb2"})], None),
        ([(100.0, "stop", Code.DONE, {**PLACE, "domain": 1})], None),
        ([(10.0, "stop", Code.DONE, PLACE)], None),  # too long ago
        ([(100.0, "go", Code.ACCEPTED, PLACE)], None),
    ],
)
def test_the_last_stop_without_a_release_is_found(
    tmp_path: Path, lines: list[Any], found: float | None
) -> None:
    file = tmp_path / "journal.jsonl"
    kept = Journal(file)
    for time, verb, code, place in lines:
        kept.write(time, "command", **AuditRecord(verb, {}, code)._asdict(), place=place)
    kept.close()
    if lines:
        with file.open("ab") as opened:
            opened.write(b'{"place": \n\xff"place"\n["place"]\n')  # cut off, no text, no entry
    assert unreleased_stop(file, PLACE, 50.0) == found
    if lines:
        file.rename(tmp_path / "journal.jsonl.1")
    assert unreleased_stop(file, PLACE, 50.0) == found
