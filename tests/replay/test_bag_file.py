"""Bags are read as they were written, by this console and by others; what is none is refused."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest
from archo_interfaces.msg import BatteryStatus
from mcap_ros2.writer import Writer as RosWriter
from rcl_interfaces.msg import Log
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import String

from archo_tui.base.errors import ArchoError
from archo_tui.recordings import store
from archo_tui.recordings.replay import bag as bag_reader
from archo_tui.recordings.replay import mcap_file
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.robot.messages.definitions import definition
from archo_tui.robot.messages.types import load_class, name_of
from archo_tui.ros import embedded
from tests.replay.bags import (
    START,
    channel,
    chunk,
    contents,
    drive,
    log,
    logs,
    message,
    read,
    record,
    schema,
    words,
    written,
)
from tests.support import chosen
from tests.support.bags import received, write
from tests.support.night import corners

FEEDBACK = "/move_to_shelf/_action/feedback"


def recorded(folder: Path, sent: list[tuple[str, Any]], **attached: str) -> Path:
    """By this console's own recorder, a tenth of a second apart."""
    folder.mkdir(exist_ok=True)
    heard = [received(START * 10**9 + n * 10**8, *one) for n, one in enumerate(sent)]
    write(folder, heard, {"why": "a test"}, **attached)
    return folder


def test_what_this_console_recorded_is_read_back_with_and_without_metadata(tmp_path: Path) -> None:
    sent = drive(60)
    found = BagFile(recorded(tmp_path / "a", sent, **{"robot.yaml": "name: X\n"}))
    assert [(one.topic, one.message) for one in read(found)] == sent
    assert (found.start, found.end, found.count) == (START, START + 5.9, 60)
    assert (found.robot, found.faults) == ("name: X\n", [])
    assert found.types == {
        "/battery_level": "archo_interfaces/msg/BatteryStatus",
        FEEDBACK: "archo_interfaces/action/MoveToShelf_FeedbackMessage",
        "/rosout": "rcl_interfaces/msg/Log",
        "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
    }
    (tmp_path / "a" / store.METADATA).unlink()
    (file,) = (tmp_path / "a").iterdir()
    assert contents(tmp_path / "a") == contents(file) == sent
    found = BagFile(recorded(tmp_path / "b", []))  # without messages it is one, too
    assert (found.start, found.end, found.count, found.types) == (0.0, 0.0, 0, {})
    assert (read(found), found.faults) == ([], [])


def test_messages_of_a_users_own_interfaces_are_read_back(tmp_path: Path) -> None:
    depot = pytest.importorskip("depot_interfaces.msg")
    sample = depot.Sample(i64s=[1, -2, 3], texts=["a", "ü"], wide="w", places=[depot.Vector(x=0.5)])
    feedback = pytest.importorskip("depot_interfaces.action").GoTo.Impl.FeedbackMessage()
    sent = [("/sample", sample), ("/charge", depot.Charge(volts=12.5)), ("/feedback", feedback)]
    found = BagFile(recorded(tmp_path / "a", sent))
    assert [(one.topic, one.message) for one in read(found)] == sent
    assert found.faults == []


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"chunk_size": 500},
        {"use_chunking": False},
        {"use_statistics": False, "enable_crcs": False},
        {"repeat_channels": False, "repeat_schemas": False},
    ],
    ids=str,
)
def test_every_way_to_pack_messages_is_read(
    options: dict[str, Any], compression: str, tmp_path: Path
) -> None:
    found = BagFile(written(tmp_path / "a.mcap", drive(), compression, **options))
    assert [(one.topic, one.message) for one in read(found)] == drive()
    assert (found.start, found.end, found.count) == (START, START + 5.9, 60)
    assert (found.robot, found.faults) == ("name: X\n", [])


@pytest.mark.parametrize("mode", [CompressionMode.NONE, CompressionMode.STORAGE])
def test_what_rosbags_wrote_is_read(mode: CompressionMode, tmp_path: Path) -> None:
    with_types = get_typestore(Stores.ROS2_JAZZY)
    said = with_types.types["std_msgs/msg/String"]
    writer = Writer(tmp_path / "a", version=9, storage_plugin=StoragePlugin.MCAP)
    if mode is not CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        chatter = writer.add_connection("/chatter", said.__msgtype__, typestore=with_types)
        logs = writer.add_connection("/rosout", "rcl_interfaces/msg/Log", typestore=with_types)
        data = with_types.serialize_cdr(said(data="hallo"), said.__msgtype__)
        writer.write(chatter, START * 10**9, data)
        writer.write(logs, START * 10**9 + 5, serialize_message(Log(msg="warm", level=30)))
    found = BagFile(tmp_path / "a")
    assert [one.message for one in read(found)] == [String(data="hallo"), Log(msg="warm", level=30)]
    assert found.faults == []


def test_a_definition_with_all_that_people_write_is_the_same_type(tmp_path: Path) -> None:
    given = """
        # a comment: string x
        byte DEBUG=10
        uint8   INFO = 20  # another one
        string HASH="a # b"

        builtin_interfaces/msg/Time   stamp\t# when
        uint8 level 3
        string name "it is"
        string<=100 msg
        string file
        string function
        uint32 line
    """
    given = dedent(given) + "=" * 80
    given += "\nMSG: builtin_interfaces/Time\n# of a clock\nint32 sec\nuint32 nanosec\n"
    with open(tmp_path / "a.mcap", "wb") as stream:
        writer = RosWriter(stream)
        known = writer.register_msgdef("rcl_interfaces/msg/Log", given.replace("/msg/T", "/T"))
        values = {"stamp": {"sec": 5, "nanosec": 7}, "level": 20, "name": "n", "msg": "said"}
        rest = {"file": "f", "function": "g", "line": 3}
        writer.write_message("/rosout", known, {**values, **rest}, START * 10**9)
        writer.finish()  # type: ignore[no-untyped-call]
    found = BagFile(tmp_path / "a.mcap")
    (one,) = read(found)
    assert (one.time, one.message.msg, one.message.stamp.nanosec) == (START, "said", 7)
    assert found.faults == []
    logs(tmp_path / "b.mcap", schema(2, "rcl_interfaces/msg/Log", given), channel(2, 2, "/more"))
    assert BagFile(tmp_path / "b.mcap").faults == []


def test_each_interface_as_its_file_says_it_is_the_type_that_is_installed(tmp_path: Path) -> None:
    pytest.importorskip("depot_interfaces")
    # Of the others there, ROS 2 may have its own, with more fields.
    others = "*" if chosen.ENGINE == "embedded" else "depot_interfaces"
    packages = [
        *(Path(embedded.__file__).parent / "share").iterdir(),
        *Path("tests/share").glob(others),
    ]
    found = [file for package in packages for file in package.glob("msg/*.msg")]
    assert len(found) > 40
    for file in found:
        type_name = f"{file.parent.parent.name}/msg/{file.stem}"
        made = load_class(type_name)
        if made is None:  # ROS 2 has no tf2_msgs on PyPI.
            continue
        _, rule, nested = definition(made).partition("=" * 80)
        parts = schema(2, type_name, file.read_text() + rule + nested) + channel(2, 2, "/other")
        bag_file = BagFile(logs(tmp_path / "a.mcap", parts))
        assert bag_file.faults == []
        assert bag_file.types["/other"] == type_name


def test_names_without_a_package_are_of_the_message_around_them(tmp_path: Path) -> None:
    pytest.importorskip("depot_interfaces")
    rule = "=" * 80
    given = (
        f"string frame_id\nPose pose\n{rule}\nMSG: depot_interfaces/msg/Pose\n"
        f"Vector position\ndepot_interfaces/msg/Quaternion orientation\n{rule}\n"
        f"MSG: depot_interfaces/Vector\nfloat64 x\nfloat64 y\nfloat64 z\n{rule}\n"
        "MSG: depot_interfaces/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w 1.0\n"
    )
    posed = schema(2, "depot_interfaces/msg/PoseStamped", given) + channel(2, 2, "/pose")
    assert (
        BagFile(logs(tmp_path / "a.mcap", posed)).types["/pose"]
        == "depot_interfaces/msg/PoseStamped"
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("uint32 line", "int32 line"),
        ("uint32 line", "uint32 number"),
        ("uint32 line", "uint32 line\nbool more"),
        ("uint8 level\nstring name", "string name\nuint8 level"),
        ("MSG: builtin_interfaces/Time", "MSG: builtin_interfaces/Clock"),
        ("builtin_interfaces/Time stamp", "builtin_interfaces/Duration stamp"),
    ],
)
def test_a_type_with_other_fields_is_left_out(old: str, new: str, tmp_path: Path) -> None:
    text = definition(Log)
    assert old in text
    other = schema(2, "rcl_interfaces/msg/Log", text.replace(old, new)) + channel(2, 2, "/other")
    sent = message(1, START, log("same")), message(2, START, log("other"))
    found = BagFile(logs(tmp_path / "a.mcap", other, *sent))
    assert [one.topic for one in read(found)] == ["/rosout"]
    said = "/other: left out: rcl_interfaces/msg/Log has other fields here than in the file"
    assert found.faults == [said]
    assert set(found.types) == {"/rosout"}
    text = definition(pytest.importorskip("depot_interfaces.msg").Sample)
    for size, faults in (("int16[<=3]", 0), ("int16[2]", 1)):  # A bound makes no difference.
        assert size in text
        known = schema(2, "depot_interfaces/msg/Sample", text.replace(size, "int16[]"))
        found = BagFile(logs(tmp_path / "a.mcap", known, channel(2, 2, "/other")))
        assert len(found.faults) == faults


@pytest.mark.parametrize(
    ("parts", "fault"),
    [
        (
            schema(2, "sea_msgs/msg/Wave", "float32 height") + channel(2, 2, "/other"),
            "/other: left out: sea_msgs/msg/Wave is not installed here",
        ),
        (
            schema(2, "rcl_interfaces/msg/Log", definition(Log)) + channel(2, 2, "/other", "json"),
            "/other: left out: encoded as json, not cdr",
        ),
        (channel(2, 9, "/other"), "/other: left out: its type is not named"),
        (
            schema(2, "rcl_interfaces/msg/Log", "module {}", "ros2idl") + channel(2, 2, "/other"),
            "/other: its definition is not compared: read as rcl_interfaces/msg/Log here",
        ),
        (
            schema(2, "std_msgs/msg/String", "string data") + channel(2, 2, "/rosout"),
            "/rosout: left out: std_msgs/msg/String, where rcl_interfaces/msg/Log came before",
        ),
    ],
)
def test_a_topic_that_cannot_be_read_is_said_once_and_left_out(
    parts: bytes, fault: str, tmp_path: Path
) -> None:
    sent = [message(n % 2 + 1, START + n, log(str(n))) for n in range(10)]
    found = BagFile(logs(tmp_path / "a.mcap", parts, *sent))
    is_read = "not compared" in fault
    assert [one.message.msg for one in read(found)] == [*map(str, range(0, 10, 2 - is_read))]
    assert found.faults == [fault]
    assert found.count == 10


def test_messages_that_cannot_be_read_are_told_once_by_their_topic(tmp_path: Path) -> None:
    data = [log("a"), b"", b"\x00\x01\x00\x00\xff", log("b")[:-6], log("c")]
    found = BagFile(
        logs(tmp_path / "a.mcap", *(message(1, START + n, one) for n, one in enumerate(data)))
    )
    for _ in range(2):
        assert words(found) == ["a", "c"]
    (fault,) = found.faults
    assert fault.startswith("/rosout: some messages cannot be read: ")


def test_only_what_is_wanted_comes_and_only_of_that_time(tmp_path: Path) -> None:
    found = BagFile(written(tmp_path / "a.mcap", drive(), chunk_size=500))
    some = list(found.messages(START + 1.0, START + 2.0, {"/rosout", "/nothing"}))
    assert [one.time for one in some] == pytest.approx([START + 1.0, START + 1.4, START + 1.8])
    assert {one.topic for one in some} == {"/rosout"}
    assert list(found.messages(START + 7, START + 9, {"/rosout"})) == []
    assert list(found.messages(START + 2, START + 1, {"/rosout"})) == []
    assert [one.time for one in found.messages(found.end, found.end, found.types)] == [found.end]


def test_messages_come_in_the_order_of_time_and_else_of_the_file(tmp_path: Path) -> None:
    times = [5, 3, 3, 9, 1, 3]
    sent = [message(1, time, log(f"{time}.{n}")) for n, time in enumerate(times)]
    packed = [chunk(b"".join(sent[:2]), start=3), chunk(b"".join(sent[2:]), start=1)]
    for name, parts in {"a": sent, "b": packed}.items():
        found = BagFile(logs(tmp_path / f"{name}.mcap", *parts))
        said = words(found)
        assert [one[0] for one in said] == ["1", "3", "3", "3", "5", "9"]
        assert said == sorted(said, key=lambda one: one[0])
        (first,) = found.messages(0.0, 2e-9, {"/rosout"})
        assert first.message.msg == "1.4"
    assert words(BagFile(tmp_path / "a.mcap"))[1:4] == ["3.1", "3.2", "3.5"]


def test_a_bag_of_several_files_is_one(tmp_path: Path) -> None:
    sent = drive(20)
    recorded(tmp_path / "a", sent[:8])
    written(tmp_path / "a" / "later_1.mcap", drive(4))
    recorded(tmp_path / "b", [], **{"robot.yaml": "name: Y\n"})
    (tmp_path / "b" / "recording_0.mcap").rename(tmp_path / "a" / "z.mcap")
    (tmp_path / "a" / ".hidden.mcap").write_bytes(b"no bag")
    (tmp_path / "a" / "broken.mcap").write_bytes(b"no bag")
    found = BagFile(tmp_path / "a")
    assert (found.count, len(read(found)), found.robot) == (12, 12, "name: X\n")
    times = [one.time for one in read(found)]
    assert times == sorted(times)
    (fault,) = found.faults
    assert fault.endswith("broken.mcap: not a bag: give a .mcap file, or a folder with some")


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
@pytest.mark.parametrize(
    "options", corners([{"chunk_size": 500}], [{}, {"use_chunking": False}]), ids=str
)
def test_a_file_that_is_cut_off_gives_what_stands_before(
    options: dict[str, Any], compression: str, tmp_path: Path
) -> None:
    data = written(tmp_path / "a.mcap", drive(), compression, **options).read_bytes()
    sent, counts = drive(), list[int]()
    for part in range(1, 51):
        (tmp_path / "b.mcap").write_bytes(data[: len(data) * part // 50])
        found = BagFile(tmp_path / "b.mcap")
        some = [(one.topic, one.message) for one in read(found)]
        assert some == sent[: len(some)]
        if found.count < 60:
            (fault,) = found.faults
            assert "cut off or damaged after" in fault
        counts.append(len(some))
    assert counts == sorted(counts)
    assert counts[-1] == 60
    if options or compression == "none":  # of which each message stands for itself
        assert len(set(counts)) > 10


def without_summary(path: Path) -> Path:
    """As a writer that was killed leaves it."""
    data = path.read_bytes()
    path.write_bytes(data[: data.rindex(record(15, bytes(4)))])
    return path


@pytest.mark.parametrize("cut", [False, True])
def test_no_chunk_is_opened_to_know_what_a_bag_holds(
    cut: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path / "a.mcap", drive(200), chunk_size=2000)
    if cut:
        without_summary(path)
    opened, unpacked = list[int](), mcap_file._unpack

    def counted(content: bytes, *given: Any, **more: Any) -> bytes:
        opened.append(len(content))
        return unpacked(content, *given, **more)

    monkeypatch.setattr("archo_tui.recordings.replay.mcap_file._unpack", counted)
    found = BagFile(path)
    assert (found.start, found.end, found.count) == (START, START + 19.9, 200)
    assert len(found.types) == 4
    assert len(opened) == 2  # where the channels are described
    before = len(opened)
    assert len(list(found.messages(START + 9, START + 9.1, found.types))) == 2
    assert len(opened) == before + 1


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_where_the_package_to_unpack_is_missing_that_is_said(
    compression: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path / "a.mcap", drive(), compression)
    package = {"zstd": "zstandard", "lz4": "lz4"}[compression]
    monkeypatch.setitem(sys.modules, {"zstd": "zstandard", "lz4": "lz4.frame"}[compression], None)
    found = BagFile(path)
    assert read(found) == []
    (fault,) = found.faults
    assert fault.endswith(f": compressed: pip install {package} reads it")


def test_a_robot_file_that_is_damaged_or_large_is_left_out(tmp_path: Path) -> None:
    path = written(tmp_path / "a.mcap", drive())
    path.write_bytes(path.read_bytes().replace(b"name: X\n", b"name: Y\n"))
    found = BagFile(path)
    assert (found.robot, found.faults) == ("", ["a.mcap: robot.yaml is left out: damaged"])
    found = BagFile(recorded(tmp_path / "b", drive(4), **{"robot.yaml": "#" * 1_000_001}))
    assert found.robot == ""
    assert found.faults == ["recording_0.mcap: robot.yaml is left out: larger than 1 MB"]


def test_more_messages_than_are_held_at_a_time_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path / "a.mcap", drive(), chunk_size=500)
    with monkeypatch.context() as patch:
        patch.setattr(bag_reader, "MAX_MESSAGES", 10)
        found = BagFile(path)
        assert [(one.topic, one.message) for one in read(found)] == drive()[:10]
        said = "more than 10 messages or 100 MB at a time: the rest is left out"
        assert found.faults == [said]
    with monkeypatch.context() as patch:
        patch.setattr(bag_reader, "MAX_BYTES", 500)
        assert 0 < len(read(BagFile(path))) < 20
    monkeypatch.setattr(mcap_file, "_MAX_RUN", 500)  # without chunks they are read in parts
    monkeypatch.setattr(mcap_file, "MAX_RECORD", 2000)
    assert contents(written(path, drive(), "none", use_chunking=False)) == drive()


def folder(*names: str) -> Any:
    def make(path: Path) -> None:
        path.mkdir()
        for name in names:
            (path / name).write_bytes(b"x")

    return make


def holds(data: bytes) -> Any:
    return lambda path: path.write_bytes(data)


NO_BAG = "not a bag: give a .mcap file, or a folder with some"
CONVERT = "an SQLite bag: `ros2 bag convert` makes an MCAP of it"
UNPACK = "compressed as a whole: unpack it (zstd -d FILE) and give what comes out"
ROS1 = "a ROS 1 bag: `rosbags-convert` makes a ROS 2 bag of it"


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda path: None, "was not found: give the folder of a bag, or a .mcap file"),
        (holds(b""), "it is empty: nothing was recorded in it"),
        (folder(), "no .mcap file is in it: give the folder of a bag"),
        (folder("metadata.yaml", "a_0.db3"), CONVERT),
        (folder("metadata.yaml", "a_0.mcap.zstd"), UNPACK),
        (holds(b"name: X\n" * 9), NO_BAG),
        (lambda path: os.mkfifo(path), "not a regular file"),
        (lambda path: path.symlink_to("/dev/zero"), "not a regular file"),
    ],
)
@pytest.mark.posix
def test_what_is_no_bag_is_refused_in_one_line(make: Any, why: str, tmp_path: Path) -> None:
    make(tmp_path / "a.mcap")
    with pytest.raises(ArchoError) as caught:
        BagFile(tmp_path / "a.mcap")
    assert str(caught.value).startswith(f"{tmp_path / 'a.mcap'}")
    assert why in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_of_other_systems_are_refused_with_the_tool_for_them(tmp_path: Path) -> None:
    for name, why in (("a.db3", CONVERT), ("a.mcap.zstd", UNPACK), ("a.bag", ROS1)):
        (tmp_path / name).write_bytes(b"another format")
        with pytest.raises(ArchoError, match=re.escape(why)):
            BagFile(tmp_path / name)
    for profile, encoding, why in (
        ("ros1", "ros1", "a ROS 1 bag"),
        ("", "json", "its messages are encoded as json, those of a ROS 2 bag as cdr"),
        ("drone", "", "its messages are encoded as nothing known"),
    ):
        path = written(tmp_path / "a.mcap", drive(), profile=profile, encoding=encoding)
        with pytest.raises(ArchoError, match=why):
            BagFile(path)
    path = written(tmp_path / "a.mcap", [("/b", BatteryStatus(percentage=5.0))], profile="")
    assert contents(path) == [("/b", BatteryStatus(percentage=5.0))]
    assert BagFile(path).types == {"/b": name_of(BatteryStatus)}


def test_a_file_that_changes_while_it_is_read_gives_what_is_there(tmp_path: Path) -> None:
    path, whole = tmp_path / "b.mcap", written(tmp_path / "a.mcap", drive(), chunk_size=500)
    data = whole.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    growing, before = BagFile(path), contents(path)
    path.write_bytes(data)
    after = [(one.topic, one.message) for one in read(growing)]
    assert after == drive()[: len(after)]
    assert len(before) <= len(after) <= len(before) + 20  # of the chunk in which it ended
    shrinking = BagFile(path)
    path.write_bytes(data[: len(data) // 2])
    some = [(one.topic, one.message) for one in read(shrinking)]
    assert 10 < len(some) < 50
    assert some == drive()[: len(some)]
    assert all(fault.endswith(" bytes: damaged") for fault in shrinking.faults)
    gone = BagFile(whole)
    whole.unlink()
    assert read(gone) == []
    assert "was not found" in gone.faults[0]


PARTS = ["a/recording_1.mcap", "recording_2.mcap.zstd", "x" * 300 + ".mcap", "notes.txt", "7"]


@pytest.mark.parametrize(
    ("named", "missing"),
    [
        (f"[recording_0.mcap, {', '.join(PARTS)}]", ["recording_1.mcap", "x" * 300 + ".mcap"]),
        *((odd, []) for odd in ("[", "7", "{a: 1}", "[[1], null, 3]")),
    ],
    ids=range(5),
)
def test_a_part_that_is_missing_is_named(named: str, missing: list[str], tmp_path: Path) -> None:
    folder = recorded(tmp_path / "a", drive(8))
    (folder / "recording_2.mcap").write_bytes((folder / "recording_0.mcap").read_bytes())
    metadata = folder / store.METADATA
    before = metadata.read_text()
    listed = "relative_file_paths:\n  - recording_0.mcap"
    text = before.replace(listed, f"relative_file_paths: {named}")
    assert text != before
    metadata.write_text(text)
    found = BagFile(folder)
    assert found.count == 16
    more = "is missing: metadata.yaml names it as a part of this bag"
    assert found.faults == [f"{name} {more}" for name in missing]


def test_damage_costs_a_chunk_and_that_of_the_summary_nothing(tmp_path: Path) -> None:
    path = written(tmp_path / "a.mcap", drive(), "none", chunk_size=1000)
    good = path.read_bytes()
    at = good.rindex(b"/rosout")
    path.write_bytes(good[:at] + b"/rotten" + good[at + 7 :])
    assert contents(path) == drive()
    assert BagFile(path).faults == []
    path.write_bytes(good.replace(b"Low battery: 20 %", b"Low battery: 99 %"))
    found = BagFile(path)
    some = [(one.topic, one.message) for one in read(found)]
    assert 40 < len(some) < 60
    assert all(one in drive() for one in some)
    (fault,) = found.faults
    assert fault.startswith("a.mcap: the chunk at ")
    assert fault.endswith(" bytes: damaged")
