"""A recording as a ROS bag: an MCAP file, and the `metadata.yaml` that rosbag2 writes beside it."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from archo_tui.base.errors import in_one_line
from archo_tui.recordings.store import METADATA
from archo_tui.robot.messages.definitions import definition
from archo_tui.robot.messages.types import name_of

_METADATA_VERSION = 9  # The version that rosbag2 of Jazzy and later write.
_MCAP_NAME = "recording_0.mcap"
_CHUNK_SIZE = 64 * 1024  # Bytes of a chunk; a damaged byte costs all of it.
_OBJECT_BYTES = 150  # Measured: a message without its content.
_YIELD_EVERY = 32  # Messages after which other threads get a turn.


class LazyMessage(NamedTuple):
    """A message of the console's own that is made only if it is written.

    `make` gets True until a message of its topic is in the bag, and Unix minus monotonic time.
    """

    make: Callable[[bool, float], Any]
    bytes: int  # That it takes while it waits, approximately.


class ReceivedMessage(NamedTuple):
    """A message as it was received."""

    time: int  # In ns, monotonic: the writer of a bag makes Unix times of them.
    topic: str  # With its namespace.
    message_class: Any
    content: bytes | LazyMessage  # CDR.

    @property
    def bytes(self) -> int:
        """The memory that it takes, approximately."""
        content = self.content
        return _OBJECT_BYTES + (len(content) if isinstance(content, bytes) else content.bytes)


class BagWriter:
    """A bag that grows on the disk; what cannot be encoded is counted in `left_out`."""

    def __init__(self, folder: Path, since: float = 0.0) -> None:
        """Create the MCAP file; `since`, in s, makes a Unix time of the time of each message."""
        from mcap.writer import CompressionType, Writer  # Takes 0.1 s.

        from archo_tui.robot.node import serialize  # Of rclpy, which verbs do without.

        try:
            import zstandard  # noqa: F401

            compression = CompressionType.ZSTD
        except ImportError:
            compression = CompressionType.NONE
        self.folder, self._since, self._serialize = folder, since, serialize
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
        self.left_out, self.first_error = 0, ""

    def add(self, messages: Iterable[ReceivedMessage]) -> None:
        """Write messages, some of which may stay in memory until `flush` or `finish`."""
        for index, message in enumerate(messages):
            if index % _YIELD_EVERY == 0:
                time.sleep(0)  # Let the threads of keys and STOP run.
            self._add(message)

    def _add(self, received: ReceivedMessage) -> None:
        at = max(received.time + int(self._since * 1e9), 0)  # MCAP has no earlier time.
        self._first = min(self._first or at, at)
        self._last, self._newest = max(self._last, at), at
        topic, kind, content = received[1:]
        try:
            name = name_of(kind)
            text = "" if name in self._schemas else definition(kind)
            if not isinstance(content, bytes):
                content = self._serialize(content.make(not self._counts[topic], self._since))
        except Exception as error:  # As for a lone surrogate in a log line; the rest is written.
            self.left_out, self.first_error = (
                self.left_out + 1,
                self.first_error or in_one_line(error),
            )
            return
        if (topic, kind) not in self._channels:
            if name not in self._schemas:
                self._schemas[name] = self._writer.register_schema(name, "ros2msg", text.encode())
            self._topics[topic] = name
            self._channels[topic, kind] = self._writer.register_channel(
                topic, "cdr", self._schemas[name], {"offered_qos_profiles": ""}
            )
        self._counts[topic] += 1
        self._writer.add_message(self._channels[topic, kind], at, content, at)

    def attach(self, attached: Mapping[str, str]) -> None:
        """Write attachments, each a text by its name, with the time of the last added message."""
        for name, text in attached.items():
            data = text.encode("utf-8", "replace")
            self._writer.add_attachment(self._newest, self._newest, name, "text/plain", data)

    def flush(self) -> None:
        """Put all messages on the disk, so that a process that is killed loses none of them."""
        # The mcap library ends a chunk by its size only, and keeps an open one in memory.
        self._writer._Writer__finalize_chunk()  # type: ignore[attr-defined]
        self._stream.flush()
        os.fsync(self._stream.fileno())

    def finish(self, about: Mapping[str, str]) -> None:
        """Write the end of the MCAP file, close it, and write `metadata.yaml` with custom data."""
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
            "custom_data": {**about, "left_out": str(self.left_out)},
            "ros_distro": "",
        }
        text = yaml.safe_dump({"rosbag2_bagfile_information": bag}, sort_keys=False)
        metadata = self.folder / METADATA
        metadata.write_text(text, encoding="utf-8")
        metadata.chmod(0o600)

    def close(self) -> None:
        """Close the file without finishing it; do nothing after `finish`. Errors are ignored."""
        with suppress(OSError):  # A full disk refuses the last bytes; what is there stays.
            self._stream.close()

    def _time_fields(self) -> dict[str, Any]:  # A new object each time, or YAML writes an alias.
        return {
            "starting_time": {"nanoseconds_since_epoch": self._first},
            "duration": {"nanoseconds": self._last - self._first},
        }
