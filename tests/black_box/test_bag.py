"""The last minute in memory, and recordings as bags that readers of others find whole."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import BatteryStatus
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from std_msgs.msg import String

from archo_tui import cli
from archo_tui.base.errors import ArchoError
from archo_tui.base.paths import state_file
from archo_tui.recordings import store
from archo_tui.recordings.bag import LazyMessage, ReceivedMessage
from archo_tui.recordings.recorder import MAX_BYTES, BlackBox, Ring
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.recordings.store import Recording
from archo_tui.robot.node import serialize
from tests.robots.test_rover import rover
from tests.support import warm
from tests.support.bags import received, write
from tests.support.console import FAST, Console, console
from tests.support.plain import operated
from tests.support.quiet import while_passes
from tests.support.stub import StandingClock
from tests.support.waiting import DEADLINE, wait_until

# a bag's metadata, with its start to be filled in
START = (
    "rosbag2_bagfile_information: {{starting_time: {{nanoseconds_since_epoch: {} }}, "
    "duration: {{nanoseconds: 5}}, message_count: 1, custom_data: {{}} }}"
)


def written(folder: Path, messages: Sequence[tuple[str, Any]]) -> None:
    """A bag of these, a millisecond apart."""
    heard = [received(10**18 + n * 10**6, *one) for n, one in enumerate(messages)]
    write(folder, heard, {"why": "a test", "kept": "no"}, **{"robot.yaml": "name: X\n"})


def by_rosbags(folder: Path) -> Iterator[tuple[str, str, Any]]:
    """Topic, type and message of each."""
    with AnyReader([folder]) as reader:
        for connection, _, raw in reader.messages():
            kind = connection.msgtype
            yield connection.topic, kind, reader.deserialize(raw, kind)


def same(read: Any, sent: Any) -> bool:
    """Field by field, whatever classes they are of."""
    if hasattr(type(sent), "get_fields_and_field_types"):
        names = sent.get_fields_and_field_types()
        names = [name for name in names if name != "structure_needs_at_least_one_member"]
        return all(same(getattr(read, name), getattr(sent, name)) for name in names)
    if isinstance(sent, (str, bytes)) or not hasattr(sent, "__len__"):
        return bool(read == sent or (read != read and sent != sent))  # not a number
    return len(read) == len(sent) and all(map(same, read, sent))


def test_every_field_of_a_message_is_read_back_by_others(tmp_path: Path) -> None:
    feedback = MoveToShelf.Impl.FeedbackMessage()
    feedback.feedback.distance_remaining, feedback.feedback.status = 9.5, "über Regal 7"
    sent = [
        ("/battery_level", BatteryStatus(percentage=18.5, voltage=21.25, battery_health="low")),
        ("/move_to_shelf/_action/feedback", feedback),
        ("/rosout", Log(level=30, name="dashboard", msg="Low battery: 18.0%\n end", line=7)),
        ("/parameter_events", ParameterEvent(node="/motor_controller")),
        ("/later", LazyMessage(lambda first, since: Log(msg="made now"), 100)),
    ]
    written(tmp_path, sent)
    read = list(by_rosbags(tmp_path))
    assert [(topic, kind) for topic, kind, _ in read] == [
        ("/battery_level", "archo_interfaces/msg/BatteryStatus"),
        ("/move_to_shelf/_action/feedback", "archo_interfaces/action/MoveToShelf_FeedbackMessage"),
        ("/rosout", "rcl_interfaces/msg/Log"),
        ("/parameter_events", "rcl_interfaces/msg/ParameterEvent"),
        ("/later", "rcl_interfaces/msg/Log"),
    ]
    for (_, _, found), (_, message) in zip(read[:4], sent[:4], strict=True):
        assert same(found, message), (found, message)
    assert read[4][2].msg == "made now"
    (tmp_path / store.METADATA).unlink()  # without it the file is read as well
    (file,) = tmp_path.iterdir()
    with AnyReader([file]) as reader:
        assert reader.message_count == 5


def test_what_it_says_about_itself_is_read_back(tmp_path: Path) -> None:
    written(tmp_path, [("/battery_level", BatteryStatus())] * 3)
    said = store.read_recording(tmp_path)
    assert (said.start, said.seconds, said.messages, said.why) == (1e9, 0.002, 3, "a test")
    assert not said.kept
    (tmp_path / store.METADATA).write_text("rosbag2_bagfile_information: [1")
    with pytest.raises(ValueError, match=r"metadata\.yaml does not describe a bag"):
        store.read_recording(tmp_path)
    for custom in ("[1]", "abc", "{start: x, why: {a: 1}}", "{why: [1, 2]}"):
        (tmp_path / store.METADATA).write_text(START.format("5").replace("{}", custom))
        assert store.read_recording(tmp_path) == Recording(tmp_path, 5e-9, 5e-9, 1, "", False)


async def live(op: Console, folder: Path) -> list[tuple[str, Any]]:
    """All that the console has heard, which is written there, by topic."""
    heard = kept(op.session.box.ring)
    write(folder, heard, {})
    return [
        (topic, deserialize_message(content, kind))
        for _, topic, kind, content in heard
        if isinstance(content, bytes)
    ]


def compare(folder: Path, heard: Sequence[tuple[str, Any]], *topics: str) -> None:
    """Both readers find just these messages."""
    assert set(topics) <= {topic for topic, _ in heard}
    read = [(topic, message) for topic, _, message in by_rosbags(folder)]
    read = [one for one in read if not one[0].startswith("/archo_tui/")]
    assert [topic for topic, _ in read] == [topic for topic, _ in heard]
    for (topic, found), (_, message) in zip(read, heard, strict=True):
        assert same(found, message), (topic, found, message)
    (file,) = folder.glob("*.mcap")
    plain = {topic for topic, message in heard if "_action/" not in topic}
    with open(file, "rb") as stream:
        found_there = make_reader(stream, decoder_factories=[DecoderFactory()])
        decoded = found_there.iter_decoded_messages(topics=plain)
        others = [(one.channel.topic, one.decoded_message) for one in decoded]
    wanted = [one for one in heard if one[0] in plain]
    assert [topic for topic, _ in others] == [topic for topic, _ in wanted]
    for (topic, found), (_, message) in zip(others, wanted, strict=True):
        assert same(found, message), (topic, found, message)


async def test_archos_drive_is_in_the_file_as_it_was_published(tmp_path: Path) -> None:
    async with console(*FAST) as op:
        await op.press("g", *"12", "enter")
        await op.until("✓ ARRIVED")
        heard = await live(op, tmp_path)
    feedback = "/move_to_shelf/_action/feedback"
    compare(tmp_path, heard, "/battery_level", "/motor_status", "/rosout", feedback)
    left = [message.feedback.distance_remaining for topic, message in heard if topic == feedback]
    assert left == sorted(left, reverse=True)


async def test_robots_with_interfaces_of_their_own_are_in_the_file_too(tmp_path: Path) -> None:
    async with rover() as (op, _):
        await op.press("g", *"1.5", "enter", *"-2", "enter", *"90", "enter")
        await op.until("✓ ARRIVED")
        heard = await live(op, tmp_path)
    compare(tmp_path, heard, "/odom", "/go_to/_action/feedback")


@pytest.mark.parametrize(
    "said",
    [
        *("[]", "x", "rosbag2_bagfile_information: [1", "rosbag2_bagfile_information: {}"),
        *(START.format(bad) for bad in ("-1", ".nan", ".inf", "1" + "0" * 400, "2026-11-22", "[]")),
        START.format("5").replace("message_count: 1", "message_count: .inf"),
        START.format("5").replace("nanoseconds: 5}", "nanoseconds: -5}"),
        pytest.param("a: " + "[" * 5000, marks=pytest.mark.night),
    ],
)
def test_what_is_no_bag_is_none_and_hinders_nobody(said: str, tmp_path: Path) -> None:
    (tmp_path / "odd").mkdir()
    (tmp_path / "odd" / store.METADATA).write_text(said)
    whole = tmp_path / "whole"
    whole.mkdir()
    written(whole, [("/rosout", Log(msg="all is well"))])
    assert [one.name for one in store.list_recordings(tmp_path)] == ["whole"]
    assert store.make_room(tmp_path, 10**9)[1] == []


def test_one_message_that_cannot_be_encoded_is_left_out_alone(tmp_path: Path) -> None:
    lines = [Log(msg="before"), Log(msg="caf\udce9"), Log(msg="behind")]
    makers = [LazyMessage(lambda *_, line=line: line, 100) for line in lines]
    heard = [received(n, "/rosout", maker) for n, maker in enumerate(makers)]
    came = write(tmp_path, heard, {})
    assert came.left_out == 1
    assert "surrogates not allowed" in came.first_error
    assert [message.msg for _, _, message in by_rosbags(tmp_path)] == ["before", "behind"]
    assert store.read_recording(tmp_path).messages == 2


def heard(seconds: float, topic: str = "/battery_level", text: str = "") -> ReceivedMessage:
    return received(int(seconds * 1e9), topic, String(data=text))


def text_of(one: ReceivedMessage) -> str:
    assert isinstance(one.content, bytes)
    said: str = deserialize_message(one.content, String).data
    return said


def texts(ring: Ring) -> list[str]:
    return [text_of(one) for one in kept(ring)]


def kept(ring: Ring) -> list[ReceivedMessage]:
    latched, number = ring.begin()
    ring.hold(float("inf"))
    return [*latched, *ring.since(number)[0]]


def test_what_is_older_than_its_span_goes() -> None:
    ring = Ring(span=60.0)
    for second in range(100):
        ring.add(heard(second, "/rosout", str(second)))
    assert texts(ring) == [str(second) for second in range(39, 100)]


def test_more_bytes_than_it_may_take_push_the_oldest_out() -> None:
    ring = Ring(max_bytes=10_000)
    for number in range(100):
        ring.add(heard(number / 1000, "/rosout", str(number).zfill(1000)))
        assert ring.bytes <= 10_000
    assert texts(ring) == [str(number).zfill(1000) for number in range(92, 100)]


def test_the_last_of_a_topic_stands_at_the_begin_though_it_is_older() -> None:
    ring = Ring(span=60.0)
    for second, topic in ((0, "/battery_level"), (1, "/battery_level"), (2, "/rosout")):
        ring.add(heard(second, topic, str(second)))
    ring.add(heard(100, "/rosout", "now"))
    assert texts(ring) == ["1", "now"]
    assert {one.time for one in kept(ring)} == {100 * 10**9}


def test_what_a_recording_has_not_taken_is_kept() -> None:
    ring = Ring(span=60.0)
    ring.add(heard(1, "/rosout", "before"))
    _, first = ring.begin()
    ring.add(heard(100, "/rosout", "after"))
    taken, following = ring.since(first)
    assert [text_of(one) for one in taken] == ["before", "after"]
    ring.hold(following)
    ring.add(heard(101, "/rosout", "more"))
    assert [text_of(one) for one in ring.since(following)[0]] == ["more"]
    ring.add(heard(200, "/rosout", "x" * MAX_BYTES))
    assert ring.first > following  # Of too many the oldest go all the same.


def test_a_message_weighs_about_what_its_bytes_do() -> None:
    assert 1000 < heard(1, text="x" * 1000).bytes < 1500
    later = LazyMessage(lambda first, since: String(), 1230)
    assert 1230 < ReceivedMessage(1, "/later", String, later).bytes < 1700


def test_one_message_that_is_too_large_alone_leaves_what_stands_with_its_time() -> None:
    ring = Ring(max_bytes=10_000)
    ring.add(heard(50, "/battery_level", "stands"))
    ring.add(heard(51, "/rosout", "x" * 20_000))
    (one,) = kept(ring)
    assert (text_of(one), one.time, ring.bytes) == ("stands", 50 * 10**9, 0)
    ring = Ring()  # What is too large does not stand on.
    ring.add(heard(1, "/map", "x" * 2_000_000))
    ring.add(heard(100, "/rosout", "now"))
    assert texts(ring) == ["now"]


# `--record`: everything that is heard, in bags of ten minutes.

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
    (tmp_path / "a file").touch()
    for name, said in (
        ("there", "it exists already: name another bag"),
        ("nowhere/bag", "nothing can be written to "),
        ("a file/bag", "nothing can be written to "),
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
