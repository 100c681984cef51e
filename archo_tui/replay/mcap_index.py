"""The index of an MCAP file: its channels, schemas, message ranges and robot file."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from io import BytesIO
from typing import Any, NamedTuple

from archo_tui.replay.chunks import Unreadable

ROBOT_ATTACHMENT = "robot.yaml"
MAX_ROBOT_FILE = 1_000_000  # Bytes.
MAX_CHANNELS = 5000
MAX_RANGES = 100_000
_MAX_NAME = 1000  # Characters of a topic or an encoding.
_MAX_SCHEMA = 256_000  # Bytes of a definition.
_MAX_ALL_SCHEMAS = 16_000_000  # Bytes of all definitions of a file.


class MessageRange(NamedTuple):
    """A part of a file that holds messages: a chunk, or messages outside of chunks.

    Attributes:
        start: The earliest log time of its messages, in ns since the epoch.
        end: The latest log time of its messages, in ns since the epoch.
        offset: Where it begins in the file, in bytes.
        size: Its size in the file, in bytes.
        is_chunk: True for a chunk.
        is_cut: True if the file ends within it.
    """

    start: int
    end: int
    offset: int
    size: int
    is_chunk: bool
    is_cut: bool = False


class Channel(NamedTuple):
    """A channel of an MCAP file: a topic, the encoding of its messages, its schema's id."""

    topic: str
    encoding: str
    schema: int


class Schema(NamedTuple):
    """A schema of an MCAP file: a message type with its definition.

    Attributes:
        name: The type, as `package/kind/Name`.
        encoding: The format of the definition, `ros2msg` for instance.
        text: The definition.
    """

    name: str
    encoding: str
    text: str


class Index:
    """The index of a file, filled record by record from the content of records.

    What is damaged or too large is left out and reported by `fault`.

    Attributes:
        profile: The profile in the file's header, `ros2` for instance; "" before that is read.
        channels: The channels by their ids.
        schemas: The schemas by their ids.
        ranges: The ranges of messages, in the order of their addition.
        start: The earliest log time, in ns since the epoch; 2**64 before `add_times`.
        end: The latest log time, in ns since the epoch; 0 before `add_times`.
        count: The number of messages.
        robot: The text of the robot file; "" if none was read.
        fault: Called with the text of each fault.
    """

    def __init__(self, fault: Callable[[str], None]) -> None:
        self.profile = ""
        self.channels: dict[int, Channel] = {}
        self.schemas: dict[int, Schema] = {}
        self.ranges: list[MessageRange] = []
        self.start, self.end, self.count = 2**64, 0, 0  # Times in ns, of the messages.
        self.robot = ""
        self.fault = fault
        self._schema_bytes = 0

    def add_header(self, content: bytes) -> None:
        """Read the profile from the header record."""
        self._try("its header", self._read_header, content)

    def add_schema(self, content: bytes) -> None:
        """Add a schema record; one whose id is known already is ignored."""
        if int.from_bytes(content[:2], "little") not in self.schemas:
            self._try("a definition", self._read_schema, content)

    def add_channel(self, content: bytes) -> None:
        """Add a channel record; one whose id is known already is ignored."""
        if int.from_bytes(content[:2], "little") not in self.channels:
            self._try("a channel", self._read_channel, content)

    def add_robot(self, content: bytes) -> None:
        """Read the robot file from an attachment record, unless one was read already."""
        if not self.robot:
            self._try(ROBOT_ATTACHMENT, self._read_robot, content)

    def add_range(self, messages: MessageRange) -> None:
        """Add a range of messages; report it instead if MAX_RANGES are there already."""
        if len(self.ranges) < MAX_RANGES:
            self.ranges.append(messages)
        else:
            self.fault(f"more than {MAX_RANGES:,} chunks: the rest is left out")

    def add_times(self, start: int, end: int, count: int) -> None:
        """Add to the number of messages, and widen the time of the whole file.

        Args:
            start: The earliest log time of the messages, in ns since the epoch.
            end: Their latest log time, in ns since the epoch.
            count: Their number.
        """
        self.start, self.end = min(self.start, start), max(self.end, end)
        self.count += count

    def _try(self, what: str, add: Callable[[bytes, Any], None], content: bytes) -> None:
        """Call `add` with a record's content and a stream of it; report any exception as a fault.

        Args:
            what: What the record is called in the report.
            add: Reads the record.
            content: The content of the record.
        """
        from mcap.data_stream import ReadDataStream

        try:
            add(content, ReadDataStream(BytesIO(content)))
        except Unreadable as error:
            self.fault(f"{what} is left out: {error}")
        except Exception:  # Of many kinds: struct's, mcap's, UnicodeDecodeError.
            self.fault(f"{what} is left out: damaged")

    def _read_header(self, _: bytes, stream: Any) -> None:
        self.profile = stream.read_prefixed_string()

    def _read_schema(self, content: bytes, stream: Any) -> None:
        if len(content) > _MAX_SCHEMA:
            raise Unreadable(f"larger than {_MAX_SCHEMA // 1000} kB")
        if self._schema_bytes + len(content) > _MAX_ALL_SCHEMAS:
            raise Unreadable(f"all of them are larger than {_MAX_ALL_SCHEMAS // 10**6} MB")
        number, name = stream.read2(), stream.read_prefixed_string()
        encoding, text = stream.read_prefixed_string(), stream.read_prefixed_string()
        self._schema_bytes += len(content)
        self.schemas[number] = Schema(name, encoding, text)

    def _read_channel(self, _: bytes, stream: Any) -> None:
        """Add a channel without its metadata, which may have millions of entries.

        Raises:
            Unreadable: There are too many channels, or a name is too long.
        """
        if len(self.channels) >= MAX_CHANNELS:
            raise Unreadable(f"more than {MAX_CHANNELS:,}")
        number, schema = stream.read2(), stream.read2()
        topic, encoding = stream.read_prefixed_string(), stream.read_prefixed_string()
        if len(topic) > _MAX_NAME or len(encoding) > _MAX_NAME:
            raise Unreadable("its name is too long")
        self.channels[number] = Channel(topic, encoding, schema)

    def _read_robot(self, content: bytes, _: Any) -> None:
        from mcap.data_stream import ReadDataStream
        from mcap.records import Attachment

        crc = int.from_bytes(content[-4:], "little")  # 0: the writer left it out.
        if crc and crc != zlib.crc32(content[:-4]):
            raise Unreadable("damaged")
        found = Attachment.read(ReadDataStream(BytesIO(content)))
        self.robot = found.data.decode()
