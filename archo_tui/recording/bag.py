"""A recording as a ROS bag: MCAP, with the `metadata.yaml` that rosbag2 writes beside it."""

from __future__ import annotations

import os
import re
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

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
_NUMBER = re.compile(r"[0-9]{1,9}")
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
    writer = BagWriter(folder)
    try:
        writer.add(heard)
        return writer.end(about, attached)
    finally:
        writer.close()


class BagWriter:
    """A bag that is written piece by piece; until its end it has no `metadata.yaml`."""

    def __init__(self, folder: Path) -> None:
        """Begin the file, in an empty folder. Raises OSError."""
        from mcap.writer import CompressionType, Writer  # on this thread only: it takes 0.1 s

        try:
            import zstandard  # noqa: F401

            compression = CompressionType.ZSTD
        except ImportError:
            compression = CompressionType.NONE
        self.folder = folder
        self._path = folder / _FILE
        self._stream = open(self._path, "xb")  # noqa: SIM115  # closed by close()
        self._path.chmod(0o600)
        self._writer = Writer(self._stream, chunk_size=_CHUNK, compression=compression)
        self._writer.start(profile="ros2", library="archo-tui")
        self._channels: dict[tuple[str, Any], int] = {}
        self._schemas: dict[str, int] = {}
        self._topics: dict[str, str] = {}
        self._number: Counter[str] = Counter()
        self._first = self._last = self._newest = 0  # ns
        self._written = Written(0, "")

    def add(self, heard: Sequence[Heard]) -> None:
        """Write messages, some of which may stay in memory until `flush` or `end`."""
        for place, one in enumerate(heard):
            if place % _SLICE == 0:
                time.sleep(0)  # keys and STOP first
            self._add(one)

    def _add(self, one: Heard) -> None:
        self._first = min(self._first or one.time, one.time)
        self._last, self._newest = max(self._last, one.time), one.time
        schemas, written = self._schemas, self._written
        try:
            kind, name, data = _encoded(one.message, first=not self._number[one.topic])
            text = "" if name in schemas else definition(kind)
        except Exception as error:  # half a character in a log line, say: the others are written
            self._written = Written(written.left_out + 1, written.why or in_one_line(error))
            return
        if (one.topic, kind) not in self._channels:
            if name not in schemas:
                schemas[name] = self._writer.register_schema(name, "ros2msg", text.encode())
            self._topics[one.topic] = name
            self._channels[one.topic, kind] = self._writer.register_channel(
                one.topic, "cdr", schemas[name], {"offered_qos_profiles": ""}
            )
        self._number[one.topic] += 1
        self._writer.add_message(self._channels[one.topic, kind], one.time, data, one.time)

    def attach(self, attached: Mapping[str, str]) -> None:
        """Write texts by name."""
        at = self._newest
        for name, said in attached.items():
            data = said.encode("utf-8", "replace")
            self._writer.add_attachment(at, at, name, "text/plain", data)

    def flush(self) -> None:
        """Put all that was added on the disk: a process that is killed then loses none of it."""
        # mcap ends a chunk by its size only; what is in an open one would be in memory
        self._writer._Writer__finalize_chunk()  # type: ignore[attr-defined]
        self._stream.flush()
        os.fsync(self._stream.fileno())

    def end(self, about: Mapping[str, str], attached: Mapping[str, str]) -> Written:
        """Write what ends the bag. Raises OSError."""
        self.attach(attached)
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._stream.close()
        counted = [
            {
                "topic_metadata": {
                    "name": topic,
                    "type": kind,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [],
                    "type_description_hash": "",
                },
                "message_count": self._number[topic],
            }
            for topic, kind in self._topics.items()
        ]
        count = sum(self._number.values())
        bag = {
            "version": _VERSION,
            "storage_identifier": "mcap",
            **self._times(),
            "message_count": count,
            "topics_with_message_count": counted,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self._path.name],
            "files": [{"path": self._path.name, **self._times(), "message_count": count}],
            "custom_data": {**about, "left_out": str(self._written.left_out)},
            "ros_distro": "",
        }
        text = yaml.safe_dump({"rosbag2_bagfile_information": bag}, sort_keys=False)
        metadata = self.folder / METADATA
        metadata.write_text(text, encoding="utf-8")
        metadata.chmod(0o600)
        return self._written

    def close(self) -> None:
        """Leave the file as it is."""
        with suppress(OSError):  # of a disk that is full: what it has is all there is
            self._stream.close()

    def _times(self) -> dict[str, Any]:  # anew each time: YAML would write a reference
        return {
            "starting_time": {"nanoseconds_since_epoch": self._first},
            "duration": {"nanoseconds": self._last - self._first},
        }


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
    number: int = 0  # in the order in which ours were written; 0: it has none


def about(folder: Path) -> About:
    """Of the bag in that folder. Raises OSError, or ValueError for what is none."""
    try:
        bag = yaml.safe_load(read(folder / METADATA))["rosbag2_bagfile_information"]
        custom = bag.get("custom_data")
        said = custom if isinstance(custom, dict) else {}
        why, number = said.get("why"), str(said.get("number"))
        return About(
            _whole(bag["starting_time"]["nanoseconds_since_epoch"]) / 1e9,
            _whole(bag["duration"]["nanoseconds"]) / 1e9,
            _whole(bag["message_count"]),
            why[:_LONGEST] if isinstance(why, str) else "",
            said.get("kept") == "yes",
            int(number) if _NUMBER.fullmatch(number) else 0,
        )
    except (yaml.YAMLError, AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise ValueError(f"{folder.name}: {METADATA} is not one of a bag") from None


def _whole(value: Any) -> int:
    """Raises ValueError for anything but a number of ns, or of messages."""
    if not isinstance(value, int) or not 0 <= value < _MOST:
        raise ValueError(value)
    return value
