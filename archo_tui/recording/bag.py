"""A recording as a ROS bag: MCAP, with the `metadata.yaml` that rosbag2 writes beside it."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import yaml

from archo_tui.errors import in_one_line
from archo_tui.recording.cdr_size import cdr_size
from archo_tui.recording.definitions import definition
from archo_tui.recording.ring import Heard, Later
from archo_tui.regular_files import read
from archo_tui.robot import message_classes

METADATA = "metadata.yaml"
_VERSION = 9  # of the metadata, as rosbag2 of Jazzy and later have it
_FILE = "recording_0.mcap"
_LONGEST = 1000  # characters of why it was written, of a bag of anybody
_MOST = 2**62  # ns since the epoch: until 2116
_CHUNK = 64 * 1024  # bytes that one damaged byte can cost
_SLICE = 32  # messages between which other threads get their turn


class Written(NamedTuple):
    """What came of writing one."""

    left_out: int  # messages that cannot be encoded
    why: str  # of the first of them


def write(
    folder: Path, heard: Sequence[Heard], about: Mapping[str, str], **attached: str
) -> Written:
    """Write the files of a bag into an empty folder. Raises OSError.

    `about` is kept as the bag's custom data, `attached` as attachments by name.
    """
    file = folder / _FILE
    with open(file, "xb") as stream:
        topics, number, written = _messages(stream, heard, attached)
    first = min((one.time for one in heard), default=0)
    last = max((one.time for one in heard), default=0)

    def times() -> dict[str, Any]:  # anew each time: YAML would write a reference
        return {
            "starting_time": {"nanoseconds_since_epoch": first},
            "duration": {"nanoseconds": last - first},
        }

    counted = [
        {
            "topic_metadata": {
                "name": topic,
                "type": kind,
                "serialization_format": "cdr",
                "offered_qos_profiles": [],
                "type_description_hash": "",
            },
            "message_count": number[topic],
        }
        for topic, kind in topics.items()
    ]
    count = sum(number.values())
    bag = {
        "version": _VERSION,
        "storage_identifier": "mcap",
        **times(),
        "message_count": count,
        "topics_with_message_count": counted,
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.name],
        "files": [{"path": file.name, **times(), "message_count": count}],
        "custom_data": {**about, "left_out": str(written.left_out)},
        "ros_distro": "",
    }
    text = yaml.safe_dump({"rosbag2_bagfile_information": bag}, sort_keys=False)
    (folder / METADATA).write_text(text, encoding="utf-8")
    return written


def _messages(
    stream: BinaryIO, heard: Sequence[Heard], attached: Mapping[str, str]
) -> tuple[dict[str, str], Counter[str], Written]:
    """Write the MCAP file; returns types and messages by topic, and what is left out."""
    from mcap.writer import CompressionType, Writer  # on this thread only: it takes 0.1 s

    try:
        import zstandard  # noqa: F401

        compression = CompressionType.ZSTD
    except ImportError:
        compression = CompressionType.NONE
    writer = Writer(stream, chunk_size=_CHUNK, compression=compression)
    writer.start(profile="ros2", library="archo-tui")
    channels: dict[tuple[str, Any], int] = {}
    schemas: dict[str, int] = {}
    topics: dict[str, str] = {}
    number: Counter[str] = Counter()
    written = Written(0, "")
    for place, one in enumerate(heard):
        if place % _SLICE == 0:
            time.sleep(0)  # keys and STOP first
        try:
            kind, name, data = _encoded(one.message, first=not number[one.topic])
            text = "" if name in schemas else definition(kind)
        except Exception as error:  # half a character in a log line, say: the others are written
            written = Written(written.left_out + 1, written.why or in_one_line(error))
            continue
        if (one.topic, kind) not in channels:
            if name not in schemas:
                schemas[name] = writer.register_schema(name, "ros2msg", text.encode())
            topics[one.topic] = name
            channels[one.topic, kind] = writer.register_channel(
                one.topic, "cdr", schemas[name], {"offered_qos_profiles": ""}
            )
        number[one.topic] += 1
        writer.add_message(channels[one.topic, kind], one.time, data, one.time)
    at = heard[-1].time if heard else 0
    for name, said in attached.items():
        writer.add_attachment(at, at, name, "text/plain", said.encode("utf-8", "replace"))
    writer.finish()  # type: ignore[no-untyped-call]
    return topics, number, written


def _encoded(message: Any, *, first: bool) -> tuple[Any, str, bytes]:
    """The class of a message, its type's name, and its bytes; `first`: of its topic."""
    from rclpy.serialization import serialize_message

    made = message.make(first) if isinstance(message, Later) else message
    return type(made), type_name(type(made)), serialize_message(made)[: cdr_size(made)]


def type_name(kind: Any) -> str:
    """`archo_interfaces/action/MoveToShelf_FeedbackMessage`."""
    return message_classes.name_of(kind)


class About(NamedTuple):
    """What `metadata.yaml` says of a bag."""

    start: float  # Unix time
    seconds: float
    messages: int
    why: str
    kept: bool


def about(folder: Path) -> About:
    """Of the bag in that folder. Raises OSError, or ValueError for what is none."""
    try:
        bag = yaml.safe_load(read(folder / METADATA))["rosbag2_bagfile_information"]
        custom = bag.get("custom_data")
        said = custom if isinstance(custom, dict) else {}
        why = said.get("why")
        return About(
            _whole(bag["starting_time"]["nanoseconds_since_epoch"]) / 1e9,
            _whole(bag["duration"]["nanoseconds"]) / 1e9,
            _whole(bag["message_count"]),
            why[:_LONGEST] if isinstance(why, str) else "",
            said.get("kept") == "yes",
        )
    except (yaml.YAMLError, AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise ValueError(f"{folder.name}: {METADATA} is not one of a bag") from None


def _whole(value: Any) -> int:
    """Raises ValueError for anything but a number of ns, or of messages."""
    if not isinstance(value, int) or not 0 <= value < _MOST:
        raise ValueError(value)
    return value
