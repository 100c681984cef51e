"""Bags for the tests of their reader."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import BatteryStatus
from mcap.writer import CompressionType, Writer
from rcl_interfaces.msg import Log, Parameter, ParameterEvent, ParameterValue
from rclpy.serialization import serialize_message

from archo_tui.recordings.replay.bag import BagFile, BagMessage
from archo_tui.robot.messages.definitions import definition
from archo_tui.robot.messages.types import name_of

START = 1_763_780_000  # Unix time of the first message, in s
ALWAYS = (float("-inf"), float("inf"))

Sent = Sequence[tuple[str, Any]]


def drive(count: int = 60) -> list[tuple[str, Any]]:
    """What a robot says while it moves, and a feedback of its action in every four."""
    said: list[tuple[str, Any]] = []
    for number in range(0, count, 4):
        feedback = MoveToShelf.Impl.FeedbackMessage()
        feedback.feedback.distance_remaining, feedback.feedback.status = 9.5, "über Regal 7"
        values = ParameterValue(type=9, string_array_value=["a", "bc"], double_array_value=[0.5])
        parameters = [Parameter(name="max_speed", value=values)]
        said += [
            ("/battery_level", BatteryStatus(percentage=float(number), voltage=21.25)),
            ("/move_to_shelf/_action/feedback", feedback),
            ("/rosout", Log(level=30, name="dashboard", msg=f"Low battery: {number} %")),
            ("/parameter_events", ParameterEvent(node="/motor", new_parameters=parameters)),
        ]
    return said[:count]


def written(
    path: Path,
    sent: Sent,
    compression: str = "zstd",
    *,
    profile: str = "ros2",
    encoding: str = "cdr",
    **options: Any,
) -> Path:
    """A file of these, a tenth of a second apart, by the writer of the MCAP project."""
    with open(path, "wb") as stream:
        writer = Writer(stream, compression=CompressionType[compression.upper()], **options)
        writer.start(profile=profile, library="a test")
        channels: dict[str, int] = {}
        writer.add_attachment(1, 1, "robot.yaml", "text/plain", b"name: X\n")
        for number, (topic, message) in enumerate(sent):
            if topic not in channels:
                kind = type(message)
                text = definition(kind).encode()
                schema = writer.register_schema(name_of(kind), "ros2msg", text)
                channels[topic] = writer.register_channel(topic, encoding, schema)
            time = START * 10**9 + number * 10**8
            writer.add_message(channels[topic], time, serialize_message(message), time)
        writer.finish()  # type: ignore[no-untyped-call]
    return path


def read(bag: BagFile, *topics: str) -> list[BagMessage]:
    """All of its messages, or those of some topics."""
    return list(bag.messages(*ALWAYS, topics or bag.types))


def contents(path: Path) -> list[tuple[str, Any]]:
    """Topic and message of each."""
    return [(one.topic, one.message) for one in read(BagFile(path))]


MAGIC = b"\x89MCAP0\r\n"


def record(opcode: int, content: bytes, length: int | None = None) -> bytes:
    """A record of a file, which may lie about its length."""
    return struct.pack("<BQ", opcode, len(content) if length is None else length) + content


def text(said: str) -> bytes:
    return struct.pack("<I", len(said.encode())) + said.encode()


def schema(number: int, name: str, definition: str, encoding: str = "ros2msg") -> bytes:
    return record(3, struct.pack("<H", number) + text(name) + text(encoding) + text(definition))


def channel(number: int, schema: int, topic: str, encoding: str = "cdr") -> bytes:
    given = struct.pack("<HH", number, schema) + text(topic) + text(encoding)
    return record(4, given + struct.pack("<I", 0))


def message(channel: int, time: int, data: bytes) -> bytes:
    return record(5, struct.pack("<HIQQ", channel, 0, time, time) + data)


def chunk(data: bytes, compression: str = "", size: int | None = None, start: int = 0) -> bytes:
    """`data` is compressed already; it may lie about its size."""
    head = struct.pack("<QQQI", start, 2**64 - 1, len(data) if size is None else size, 0)
    return record(6, head + text(compression) + struct.pack("<Q", len(data)) + data)


def log(words: str) -> bytes:
    """The bytes of a message on channel 1 of `logs`."""
    return serialize_message(Log(msg=words))


def logs(path: Path, *parts: bytes) -> Path:
    """A file with a channel of logs, and these records behind."""
    beginning = record(1, text("ros2") + text("a test"))
    known = schema(1, "rcl_interfaces/msg/Log", definition(Log)) + channel(1, 1, "/rosout")
    path.write_bytes(b"".join([MAGIC, beginning, known, *parts, record(15, bytes(4))]))
    return path


def words(bag: BagFile) -> list[str]:
    """What the logs in it say."""
    return [one.message.msg for one in read(bag, "/rosout")]
