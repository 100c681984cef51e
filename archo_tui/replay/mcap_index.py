"""What an MCAP file holds and where: channels, schemas, chunks, the robot file."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from io import BytesIO
from typing import Any, NamedTuple

from archo_tui.replay.chunks import Unreadable

ROBOT = "robot.yaml"
MOST_ATTACHED = 1_000_000  # bytes of the robot file
MOST_CHANNELS = 5000
MOST_PIECES = 100_000
_LONGEST = 1000  # characters of a topic
_LARGEST_SCHEMA = 256_000  # bytes of a definition
_ALL_SCHEMAS = 16_000_000  # bytes of all the definitions of a file


class Piece(NamedTuple):
    """A part of a file that holds messages: a chunk, or messages that follow each other."""

    start: int  # ns since the epoch, of its first message
    end: int
    place: int  # bytes from the begin of the file
    size: int
    is_chunk: bool
    cut: bool = False  # the file ends within it


class Channel(NamedTuple):
    """A topic with a type."""

    topic: str
    encoding: str
    schema: int


class Schema(NamedTuple):
    """A type with its definition."""

    name: str
    encoding: str
    text: str


class Index:
    """Filled record by record; what is too large or damaged is left out and said by `fault`."""

    def __init__(self, fault: Callable[[str], None]) -> None:
        self.profile = ""
        self.channels: dict[int, Channel] = {}
        self.schemas: dict[int, Schema] = {}
        self.pieces: list[Piece] = []
        self.start, self.end, self.count = 2**64, 0, 0  # ns, of the messages
        self.robot = ""
        self.fault = fault
        self._text = 0  # bytes of all definitions

    def add_header(self, content: bytes) -> None:
        self._try("its header", self._header, content)

    def add_schema(self, content: bytes) -> None:
        if int.from_bytes(content[:2], "little") not in self.schemas:
            self._try("a definition", self._schema, content)

    def add_channel(self, content: bytes) -> None:
        if int.from_bytes(content[:2], "little") not in self.channels:
            self._try("a channel", self._channel, content)

    def add_robot(self, content: bytes) -> None:
        """Of an attachment of that name; the first counts."""
        if not self.robot:
            self._try(ROBOT, self._attachment, content)

    def add_piece(self, piece: Piece) -> None:
        if len(self.pieces) < MOST_PIECES:
            self.pieces.append(piece)
        else:
            self.fault(f"more than {MOST_PIECES:,} chunks: the rest is left out")

    def add_times(self, start: int, end: int, count: int) -> None:
        """Of so many messages."""
        self.start, self.end = min(self.start, start), max(self.end, end)
        self.count += count

    def _try(self, what: str, add: Callable[[bytes, Any], None], content: bytes) -> None:
        from mcap.data_stream import ReadDataStream

        try:
            add(content, ReadDataStream(BytesIO(content)))
        except Unreadable as error:
            self.fault(f"{what} is left out: {error}")
        except Exception:  # of many kinds: struct's, mcap's, of text
            self.fault(f"{what} is left out: damaged")

    def _header(self, _: bytes, stream: Any) -> None:
        self.profile = stream.read_prefixed_string()

    def _schema(self, content: bytes, stream: Any) -> None:
        if len(content) > _LARGEST_SCHEMA:
            raise Unreadable(f"larger than {_LARGEST_SCHEMA // 1000} kB")
        if self._text + len(content) > _ALL_SCHEMAS:
            raise Unreadable(f"all of them are larger than {_ALL_SCHEMAS // 10**6} MB")
        number, name = stream.read2(), stream.read_prefixed_string()
        encoding, text = stream.read_prefixed_string(), stream.read_prefixed_string()
        self._text += len(content)
        self.schemas[number] = Schema(name, encoding, text)

    def _channel(self, _: bytes, stream: Any) -> None:
        """Without its metadata, of which there may be millions."""
        if len(self.channels) >= MOST_CHANNELS:
            raise Unreadable(f"more than {MOST_CHANNELS:,}")
        number, schema = stream.read2(), stream.read2()
        topic, encoding = stream.read_prefixed_string(), stream.read_prefixed_string()
        if len(topic) > _LONGEST or len(encoding) > _LONGEST:
            raise Unreadable("its name is too long")
        self.channels[number] = Channel(topic, encoding, schema)

    def _attachment(self, content: bytes, _: Any) -> None:
        from mcap.data_stream import ReadDataStream
        from mcap.records import Attachment

        crc = int.from_bytes(content[-4:], "little")  # 0: the writer has left it out
        if crc and crc != zlib.crc32(content[:-4]):
            raise Unreadable("damaged")
        found = Attachment.read(ReadDataStream(BytesIO(content)))
        self.robot = found.data.decode()
