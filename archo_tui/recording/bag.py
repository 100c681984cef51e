"""A recording as a ROS bag: an MCAP file, and the `metadata.yaml` that rosbag2 writes beside it."""

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
from archo_tui.recording.ring import LazyMessage, ReceivedMessage
from archo_tui.regular_files import read
from archo_tui.robot.messages.cdr import cdr_size
from archo_tui.robot.messages.definitions import definition
from archo_tui.robot.messages.types import name_of

METADATA = "metadata.yaml"
_METADATA_VERSION = 9  # The version that rosbag2 of Jazzy and later write.
_MCAP_NAME = "recording_0.mcap"
_MAX_REASON = 1000  # Characters; another tool's bag may hold any text.
_MAX_COUNT = 2**63  # In ns since the epoch, an int64 of rosbag2: the year 2262.
_NANOSECONDS = re.compile(r"[0-9]{1,19}")
_NUMBER = re.compile(r"[0-9]{1,9}")
_CHUNK_SIZE = 64 * 1024  # Bytes of a chunk; a damaged byte costs all of it.
_YIELD_EVERY = 32  # Messages after which other threads get a turn.


class WriteResult(NamedTuple):
    """The messages that writing a bag has left out.

    Attributes:
        left_out: The number of messages that could not be encoded.
        first_error: Why the first of them could not be; "" if none was left out.
    """

    left_out: int
    first_error: str


def write(
    folder: Path,
    messages: Sequence[ReceivedMessage],
    about: Mapping[str, str],
    since: float = 0.0,
    /,
    **attached: str,
) -> WriteResult:
    """Write a whole bag into an empty folder; messages that cannot be encoded are left out.

    If the disk refuses it, what is written by then stays in the folder.

    Args:
        folder: The folder, which exists.
        messages: The messages, which are written in this order.
        about: The bag's custom data in `metadata.yaml`.
        since: As for `BagWriter`.
        attached: The text of each attachment by its name.

    Raises:
        OSError: The disk refuses it.
    """
    writer = BagWriter(folder, since)
    try:
        writer.add(messages)
        return writer.finish(about, attached)
    finally:
        writer.close()


class BagWriter:
    """A bag that grows on the disk; `finish` writes its `metadata.yaml`, `close` closes it.

    Messages are compressed if zstandard is installed.
    """

    def __init__(self, folder: Path, since: float = 0.0) -> None:
        """Create the MCAP file in an empty folder, readable by its owner only.

        Args:
            folder: The folder.
            since: Seconds to add to the time of each message, to make it a Unix time.

        Raises:
            OSError: The disk refuses it, or the file exists.
        """
        from mcap.writer import CompressionType, Writer  # Takes 0.1 s.

        try:
            import zstandard  # noqa: F401

            compression = CompressionType.ZSTD
        except ImportError:
            compression = CompressionType.NONE
        self.folder, self._since = folder, since
        self._path = folder / _MCAP_NAME
        self._stream = open(self._path, "xb")  # noqa: SIM115  # closed by close()
        self._path.chmod(0o600)
        self._writer = Writer(self._stream, chunk_size=_CHUNK_SIZE, compression=compression)
        self._writer.start(profile="ros2", library="archo-tui")
        self._channels: dict[tuple[str, Any], int] = {}
        self._schemas: dict[str, int] = {}
        self._topics: dict[str, str] = {}
        self._counts: Counter[str] = Counter()
        self._first = self._last = self._newest = 0  # In ns since the epoch.
        self._result = WriteResult(0, "")

    def add(self, messages: Sequence[ReceivedMessage]) -> None:
        """Write messages, some of which may stay in memory until `flush` or `finish`.

        Those that cannot be encoded are left out and counted for `finish`.

        Raises:
            OSError: The disk refuses it.
        """
        for index, message in enumerate(messages):
            if index % _YIELD_EVERY == 0:
                time.sleep(0)  # Let the threads of keys and STOP run.
            self._add(message)

    def _add(self, received: ReceivedMessage) -> None:
        """Encode and write a message; one that cannot be encoded is left out and counted."""
        at = max(received.time + int(self._since * 1e9), 0)  # MCAP has no earlier time.
        self._first = min(self._first or at, at)
        self._last, self._newest = max(self._last, at), at
        schemas, result = self._schemas, self._result
        try:
            is_first = not self._counts[received.topic]
            kind, name, data = _encode(received.message, is_first, self._since)
            text = "" if name in schemas else definition(kind)
        except Exception as error:  # As for a lone surrogate in a log line; the rest is written.
            self._result = WriteResult(
                result.left_out + 1, result.first_error or in_one_line(error)
            )
            return
        if (received.topic, kind) not in self._channels:
            if name not in schemas:
                schemas[name] = self._writer.register_schema(name, "ros2msg", text.encode())
            self._topics[received.topic] = name
            self._channels[received.topic, kind] = self._writer.register_channel(
                received.topic, "cdr", schemas[name], {"offered_qos_profiles": ""}
            )
        self._counts[received.topic] += 1
        self._writer.add_message(self._channels[received.topic, kind], at, data, at)

    def attach(self, attached: Mapping[str, str]) -> None:
        """Write attachments, each a text by its name, with the time of the last added message.

        Raises:
            OSError: The disk refuses it.
        """
        at = self._newest
        for name, text in attached.items():
            data = text.encode("utf-8", "replace")
            self._writer.add_attachment(at, at, name, "text/plain", data)

    def flush(self) -> None:
        """Put all messages on the disk, so that a process that is killed loses none of them.

        Raises:
            OSError: The disk refuses it.
        """
        # The mcap library ends a chunk by its size only, and keeps an open one in memory.
        self._writer._Writer__finalize_chunk()  # type: ignore[attr-defined]
        self._stream.flush()
        os.fsync(self._stream.fileno())

    def finish(self, about: Mapping[str, str], attached: Mapping[str, str]) -> WriteResult:
        """Write the attachments and the end of the MCAP file, close it, and write `metadata.yaml`.

        Args:
            about: The bag's custom data; the number of messages left out is added to it.
            attached: The text of each further attachment by its name.

        Raises:
            OSError: The disk refuses it.
        """
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
                "message_count": self._counts[topic],
            }
            for topic, kind in self._topics.items()
        ]
        count = sum(self._counts.values())
        bag = {
            "version": _METADATA_VERSION,
            "storage_identifier": "mcap",
            **self._time_fields(),
            "message_count": count,
            "topics_with_message_count": counted,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self._path.name],
            "files": [{"path": self._path.name, **self._time_fields(), "message_count": count}],
            "custom_data": {**about, "left_out": str(self._result.left_out)},
            "ros_distro": "",
        }
        text = yaml.safe_dump({"rosbag2_bagfile_information": bag}, sort_keys=False)
        metadata = self.folder / METADATA
        metadata.write_text(text, encoding="utf-8")
        metadata.chmod(0o600)
        return self._result

    def close(self) -> None:
        """Close the file without finishing it; do nothing after `finish`. Errors are ignored."""
        with suppress(OSError):  # A full disk refuses the last bytes; what is there stays.
            self._stream.close()

    def _time_fields(self) -> dict[str, Any]:  # A new object each time, or YAML writes an alias.
        return {
            "starting_time": {"nanoseconds_since_epoch": self._first},
            "duration": {"nanoseconds": self._last - self._first},
        }


def _encode(message: Any, first: bool, since: float) -> tuple[Any, str, bytes]:
    """Return a message's class, the name of its type, and its bytes as CDR.

    Args:
        message: The message, or the LazyMessage that makes it.
        first: True until a message of its topic is in the bag.
        since: Unix time minus monotonic time, in s.
    """
    from rclpy.serialization import serialize_message

    made = message.make(first, since) if isinstance(message, LazyMessage) else message
    return type(made), type_name(type(made)), serialize_message(made)[: cdr_size(made)]


def type_name(kind: Any) -> str:
    """Return the type of a message class, such as `std_msgs/msg/String`."""
    return name_of(kind)


class BagInfo(NamedTuple):
    """The description of a bag in its `metadata.yaml`.

    Attributes:
        start: Unix time of the first message, in s.
        seconds: The time from the first message to the last.
        messages: Their number.
        why: What triggered the recording; "" if another tool wrote the bag.
        kept: True if the operator asked for the recording.
        number: The place in the order of writing; 0 if another tool wrote the bag.
        at: Unix time of the first trigger, in s; None if there was none, or it is not known.
    """

    start: float  # Unix time, in s.
    seconds: float
    messages: int
    why: str
    kept: bool
    number: int = 0  # The place in the order of writing; 0: another tool wrote the bag.
    at: float | None = None  # Unix time of the first trigger, in s; None if there was none.


def read_info(folder: Path) -> BagInfo:
    """Return what `metadata.yaml` says of the bag in a folder; another tool's bag is read, too.

    Raises:
        OSError: `metadata.yaml` cannot be read.
        ValueError: It does not describe a bag.
    """
    try:
        bag = yaml.safe_load(read(folder / METADATA))["rosbag2_bagfile_information"]
        custom = bag.get("custom_data")
        ours = custom if isinstance(custom, dict) else {}
        why, number, at = ours.get("why"), str(ours.get("number")), str(ours.get("at"))
        return BagInfo(
            _checked_count(bag["starting_time"]["nanoseconds_since_epoch"]) / 1e9,
            _checked_count(bag["duration"]["nanoseconds"]) / 1e9,
            _checked_count(bag["message_count"]),
            why[:_MAX_REASON] if isinstance(why, str) else "",
            ours.get("kept") == "yes",
            int(number) if _NUMBER.fullmatch(number) else 0,
            int(at) / 1e9 if _NANOSECONDS.fullmatch(at) else None,
        )
    except (yaml.YAMLError, AttributeError, KeyError, TypeError, ValueError, RecursionError):
        raise ValueError(f"{folder.name}: {METADATA} does not describe a bag") from None


def _checked_count(value: Any) -> int:
    """Return a count of nanoseconds or messages; raise ValueError if it is none or too large."""
    if not isinstance(value, int) or not 0 <= value < _MAX_COUNT:
        raise ValueError(value)
    return value
