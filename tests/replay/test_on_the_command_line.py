"""`archo-tui replay`: which recording is meant, its story as text, and what is said of others."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui import cli
from archo_tui.base.clock import time_of_day
from archo_tui.base.paths import state_file
from archo_tui.recordings import store
from archo_tui.recordings.console import JOURNAL, STATE
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.recordings.replay.player import (
    find_recording,
    load_robot_file,
    opening_time,
    report_lines,
)
from tests.replay.recorded import written
from tests.replay.test_others_bags import BEGIN, drain
from tests.support import chosen, clock
from tests.support.bags import received, write
from tests.support.console import LONG, console
from tests.support.terminal import Terminal

pytestmark = pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="a replay has the embedded engine, whatever recorded it"
)


async def test_the_story_is_told_line_by_line(drive: Path) -> None:
    bag_file = BagFile(drive)
    head, *told = report_lines(bag_file, load_robot_file(bag_file, ""))
    assert head.startswith(f"{drive.name}: ARCHO, 2023-11-14 22:13:20, ")
    said = [line.partition("  ")[2] for line in told]
    for wanted in (
        "YOU console: go to shelf 12: accepted",
        "WARN motor_controller: Emergency stop",
        "YOU console: STOP: confirmed",
        "▲ MED: STOPPED: look for the cause",
    ):
        assert said.count(wanted) == 1
    assert said.index("YOU console: go to shelf 12: accepted") < said.index(
        "YOU console: STOP: confirmed"
    )


@pytest.mark.parametrize("silence", [60, 30_000])
def test_contact_that_was_lost_between_two_messages_is_told(silence: int, tmp_path: Path) -> None:
    heard = [one for one in drain(seconds=20) if one.topic != "/rosout"]
    heard += [one._replace(time=one.time + (20 + silence) * 10**9) for one in heard]
    write(tmp_path, heard, {})
    found = BagFile(tmp_path)
    _, *told = report_lines(found, load_robot_file(found, ""))
    lost, over = time_of_day(BEGIN + 23), time_of_day(BEGIN + 20 + silence + 1)
    assert told == [
        f"{lost}  ✗ HIGH: CONTACT LOST for 4 s: the robot may still be moving",
        f"{over}  over: contact lost",
    ]


async def test_without_a_name_the_newest_is_meant_and_opens_before_its_trigger() -> None:
    async with console(*LONG) as op:
        await op.at(clock.seconds() + 20.0)
        await op.press("ctrl+x")
        await op.until("STOPPED: look for the cause")
        pressed = op.app.view.time
        path = await written(op)
    bag_file = BagFile(path)
    opens = opening_time(path, bag_file.start)
    assert opens > bag_file.start + 5.0
    assert abs(opens - (pressed - 5.0)) < 1.0
    path = store.list_recordings(state_file("recordings"))[-1].folder  # one more at its end
    older = path.with_name("an_older_one")
    shutil.copytree(path, older)
    said = (older / "metadata.yaml").read_text(encoding="utf-8")
    (older / "metadata.yaml").write_text(said.replace("17000000", "16000000"), encoding="utf-8")
    assert find_recording("") == path
    assert find_recording("an_older_one") == older
    assert find_recording(str(older)) == older


@pytest.mark.parametrize("at", ["", "soon", "-1", "9" * 30, "1"])
def test_a_bag_without_a_known_trigger_opens_at_its_beginning(at: str, tmp_path: Path) -> None:
    begin = 1_700_000_000
    heard = [received(begin * 10**9, "/rosout", Log(name="dashboard", msg="as always"))]
    write(tmp_path, heard, {"at": at} if at else {})
    assert opening_time(tmp_path, begin) == begin
    assert opening_time(tmp_path / "no_bag", begin) == begin


def test_an_event_behind_one_with_a_high_number_is_told(tmp_path: Path) -> None:
    begin = 1_700_000_000
    line = {
        **{"time": begin - 9.0, "level": "INFO", "source": "dashboard", "text": "as always"},
        **{"command": "", "count": 7, "first": begin - 60.0, "number": 5321},
    }
    said = String(data=json.dumps({"events": [line]}))
    messages = [
        (0, STATE, said),
        (1, "/rosout", Log(level=20, name="dashboard", msg="as always")),
        (2, JOURNAL, Log(level=20, name="console", msg="YOU: STOP: confirmed")),
    ]
    heard = [received((begin + at) * 10**9, topic, one) for at, topic, one in messages]
    write(tmp_path, heard, {})
    bag_file = BagFile(tmp_path)
    told = list(report_lines(bag_file, load_robot_file(bag_file, "")))
    assert told[-1].endswith("YOU console: STOP: confirmed")


def test_an_alarm_is_told_before_what_followed_its_beginning(tmp_path: Path) -> None:
    begin = 1_700_000_000
    alarm = {"name": "stopped", "text": "STOPPED", "since": begin + 1.0}
    messages = [
        (0, STATE, String(data="{}")),
        (2, JOURNAL, Log(level=20, name="console", msg="YOU: go to shelf 12: accepted")),
        (3, STATE, String(data=json.dumps({"alarms": [alarm]}))),
        (4, JOURNAL, Log(level=20, name="console", msg="YOU: STOP: confirmed")),
    ]
    write(tmp_path, [received((begin + at) * 10**9, topic, one) for at, topic, one in messages], {})
    bag_file = BagFile(tmp_path)
    _, *told = report_lines(bag_file, load_robot_file(bag_file, ""))
    assert [line[:8] for line in told] == [time_of_day(begin + at) for at in (1, 2, 4)]


def test_the_robot_is_as_the_recording_says_unless_another_file_is_given(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    folder.mkdir()
    text = "name: RECORDED\nbattery: {topic: x, types: {std_msgs/msg/Float32: {percentage: data}}}"
    write(folder, drain(seconds=2), {}, **{"robot.yaml": text})
    assert load_robot_file(BagFile(folder), "").name == "RECORDED"
    other = tmp_path / "other.yaml"
    other.write_text(text.replace("RECORDED", "OTHER"), encoding="utf-8")
    assert load_robot_file(BagFile(folder), str(other)).name == "OTHER"


def test_what_cannot_be_replayed_is_one_line(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, heard, attached in (("empty", [], ""), ("wrong", drain(seconds=2), "name: [\n")):
        (here / name).mkdir()
        write(here / name, heard, {}, **{"robot.yaml": attached})
    folder = state_file("recordings")
    for is_one_there in (False, True):
        unknown = "no recording is called {} (see archo-tui " if is_one_there else "no recordings "
        for words, said in (
            (["--text"], "no recordings "),
            (["--text", "two"], unknown.format("two")),
            (["--text", "n" * 300], unknown.format("n" * 300)),
            (["--text", "/nowhere/at/all"], "/nowhere/at/all"),
            (["--text", "/" + "n" * 300], "File name too long"),
            (["--text", "./empty"], "empty: no message is in it\n"),
            (["--text", "./wrong"], "robot.yaml"),
            ([], "run archo-tui in one, or use --text\n"),
        ):
            if not is_one_there or words != ["--text"]:
                assert cli.main(["replay", *words]) == 2
                out, err = capsys.readouterr()
                assert (out, err.count("\n")) == ("", 1)
                assert said in err
        if not is_one_there:
            (folder / "one").mkdir(parents=True)
            write(folder / "one", drain(seconds=2), {})


FAILS = """
from archo_tui.cli import main
from archo_tui.screen.main import MainScreen
def fail(*_):
    raise ZeroDivisionError("of the screen")
MainScreen.show = fail
sys.exit(main(["replay", {path!r}]))
"""


def test_a_screen_that_fails_leaves_the_terminal_as_it_was(
    tmp_path: Path, terminals: list[Terminal]
) -> None:
    write(tmp_path, drain(seconds=2), {})
    terminal = Terminal(code=FAILS.format(path=str(tmp_path)))
    terminals.append(terminal)
    assert terminal.exit_code() == 1
    assert "the screen crashed: ZeroDivisionError: of the screen" in terminal.text
    assert terminal.is_as_before()
