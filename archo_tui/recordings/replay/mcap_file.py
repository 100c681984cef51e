"""The reader of an MCAP file of any tool: what it holds, and the bytes of its messages.

Records are parsed by the `mcap` package. Its readers load every chunk, unpack whatever a chunk
claims to hold, and end at the first damaged byte; so records are found and chunks are unpacked
here. Memory and time are bounded whatever a file says. The format: https://mcap.dev/spec.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping
from io import BytesIO
from struct import Struct
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

if TYPE_CHECKING:
    from mcap.records import Channel, Schema

MAGIC = b"\x89MCAP0\r\n"
MAX_RECORD = 64_000_000  # Bytes of a record in memory, or of an unpacked chunk.
_MAX_RECORDS = 3_000_000  # Of one pass, which takes some seconds; a part counts as 30.
_MAX_BYTES = 4_000_000_000  # Read and unpacked in one pass, in some seconds.
_MAX_DESCRIBED = 16_000_000  # Bytes of all definitions and channels of a recording,
_DESCRIPTION = 2000  # each with so many more: it is looked for, and takes memory.
_MAX_METADATA = 1_000_000  # Bytes of a schema, channel or robot file that are read.
_PART = 30  # Records as which a part counts.
_MAX_RUN = 1_000_000  # Bytes of messages outside of chunks in one part.
_WINDOW = 2**26  # Bytes that zstd may look back; its own writers ask for 8 MB at most.
_ROBOT = "robot.yaml"

_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _MESSAGE_INDEX = range(1, 8)
_ATTACHMENT, _DATA_END = 9, 15
_CUT = 0  # In place of an opcode: here the file is cut off or damaged.
_END_RECORDS = ((_DATA_END, 4), (_FOOTER, 20))  # Opcode and length of the records after messages.
_FRAME = Struct("<BQ")  # Opcode and length, before each record.
_MESSAGE_HEAD = Struct("<HIQQ")  # Channel, sequence, log time, publish time.
_CHUNK_TIMES = Struct("<QQ")
_MESSAGE_INDEX_HEAD = Struct("<HI")  # Channel, bytes that follow.
_MESSAGE_INDEX_ENTRY = 16  # Bytes.
_NAME_END = 16 + 4 + len(_ROBOT)  # Offset at which the name of a robot file's attachment ends.
_NAMES = {
    _HEADER: "its header",
    _SCHEMA: "a definition",
    _CHANNEL: "a channel",
    _ATTACHMENT: _ROBOT,
}


class Unreadable(Exception):
    """A part of a file cannot be read, and in a few words why; the rest may be readable."""

    def __init__(self, why: str = "damaged") -> None:
        super().__init__(why)


class BudgetExceeded(Exception):
    """The end of a pass over a recording whose Budget is used up."""


class Budget:
    """The records and bytes that one pass over a recording may still read."""

    def __init__(self) -> None:
        self._records, self._bytes, self._described = _MAX_RECORDS, _MAX_BYTES, _MAX_DESCRIBED

    def spend(self, records: int = 0, size: int = 0) -> None:
        """Take records and bytes off, or raise BudgetExceeded if they are not left."""
        self._records, self._bytes = self._records - records, self._bytes - size
        if self._records < 0:
            raise BudgetExceeded(f"more than {_MAX_RECORDS:,} records")
        if self._bytes < 0:
            raise BudgetExceeded(f"more than {_MAX_BYTES // 10**9} GB")

    def spend_description(self, size: int) -> None:
        """Take a definition or channel of so many bytes off, or raise Unreadable."""
        self._described -= size + _DESCRIPTION
        if self._described < 0:
            raise Unreadable(f"all of them are larger than {_MAX_DESCRIBED // 10**6} MB")


class Part(NamedTuple):
    """A part of a file that holds messages: a chunk, or a run of messages outside of chunks."""

    start: int  # The earliest log time of its messages, in ns since the epoch.
    end: int  # The latest.
    offset: int  # In bytes.
    size: int
    is_chunk: bool
    is_cut: bool = False  # The file ends within it.


class _Record(NamedTuple):
    opcode: int
    offset: int  # Of its content, in bytes.
    length: int
    is_cut: bool = False  # The file ends within it.


class Index:
    """The index of a file; `fault` gets what is damaged or too large."""

    def __init__(
        self, file: BinaryIO, size: int, budget: Budget, fault: Callable[[str], None]
    ) -> None:
        self.profile = self.robot = ""
        self.channels: dict[int, Channel] = {}
        self.schemas: dict[int, Schema] = {}
        self.parts: list[Part] = []
        self.start, self.end, self.count = 2**64, 0, 0  # Times in ns, of all messages.
        self._file, self._size, self._budget, self._fault = file, size, budget, fault

    def fill(self) -> None:
        """Read the records between the chunks; unpack a chunk only if its index lacks something."""
        records = _records(self._file, len(MAGIC), self._size, self._budget)
        record = next(records, None)
        while record is not None and (record.opcode, record.length) not in _END_RECORDS:
            self._file.seek(record.offset)
            if record.opcode == _CHUNK:
                record = self._add_chunk(record, records)
            elif record.opcode == _MESSAGE:
                record = self._add_run(record, records)
            elif record.opcode == _CUT:
                self._fault_of_cut(record.offset)
                return
            else:
                self._take(record)
                record = next(records, None)
        if record is None:
            self._fault_of_cut(self._size)

    def _fault_of_cut(self, offset: int) -> None:
        self._fault(f"cut off or damaged after {offset} bytes: what stands before is read")

    def _read(self, count: int) -> bytes:
        self._budget.spend(size=count)
        return self._file.read(count)

    def _take(self, record: _Record) -> None:
        if record.opcode == _ATTACHMENT:
            name = self._file.read(min(record.length, _NAME_END))
            if name[16:] != len(_ROBOT).to_bytes(4, "little") + _ROBOT.encode():
                return
            if record.length > _MAX_METADATA:
                most = f"{_MAX_METADATA // 10**6} MB"
                self._fault(f"{_ROBOT} is left out: larger than {most}")
                return
            self._parse(_ATTACHMENT, name + self._read(record.length - len(name)))
        elif record.opcode in _NAMES:
            self._parse(record.opcode, self._read(min(record.length, _MAX_METADATA)))

    def _parse(self, opcode: int, content: bytes) -> None:
        """Parse a record of metadata; one whose id is known is ignored."""
        from mcap import records
        from mcap.data_stream import ReadDataStream

        stream, number = ReadDataStream(BytesIO(content)), int.from_bytes(content[:2], "little")
        try:
            if opcode == _HEADER:
                self.profile = stream.read_prefixed_string()
            elif opcode == _SCHEMA and number not in self.schemas:
                self._budget.spend_description(len(content))
                self.schemas[number] = records.Schema.read(stream)
            elif opcode == _CHANNEL and number not in self.channels:
                self._budget.spend_description(len(content))
                self.channels[number] = records.Channel.read(stream)
            elif opcode == _ATTACHMENT and not self.robot:
                crc = int.from_bytes(content[-4:], "little")  # 0: the writer left it out.
                if crc and crc != zlib.crc32(content[:-4]):
                    raise Unreadable
                self.robot = records.Attachment.read(stream).data.decode()
        except Unreadable as error:
            self._fault(f"{_NAMES[opcode]} is left out: {error}")
        except Exception:  # Of many kinds: struct's, mcap's, UnicodeDecodeError.
            self._fault(f"{_NAMES[opcode]} is left out: damaged")

    def _add_part(self, part: Part, count: int) -> None:
        self._budget.spend(records=_PART)
        self.start, self.end = min(self.start, part.start), max(self.end, part.end)
        self.count += count
        self.parts.append(part)

    def _add_run(self, message: _Record, records: Iterator[_Record]) -> _Record | None:
        """Add the messages that follow each other as one part; return the record behind them."""
        start, end, count, begin = 2**64, 0, 0, message.offset - _FRAME.size
        record: _Record | None = message
        behind = begin
        try:
            while record is not None and record.opcode == _MESSAGE and behind - begin < _MAX_RUN:
                self._file.seek(record.offset)
                head = self._file.read(min(record.length, _MESSAGE_HEAD.size))
                if len(head) < _MESSAGE_HEAD.size or record.length > MAX_RECORD:
                    self._fault("messages that are damaged or too large are left out")
                    record = next(records, None)
                    break
                time = _MESSAGE_HEAD.unpack(head)[2]
                start, end, count = min(start, time), max(end, time), count + 1
                behind = record.offset + record.length
                record = next(records, None)
        finally:
            if count:
                self._add_part(Part(start, end, begin, behind - begin, is_chunk=False), count)
        return record

    def _add_chunk(self, chunk: _Record, records: Iterator[_Record]) -> _Record | None:
        """Add a chunk by its message index, else by what it holds; return the record behind it."""
        times = self._file.read(_CHUNK_TIMES.size)
        start, end = _CHUNK_TIMES.unpack(times) if len(times) == _CHUNK_TIMES.size else (0, 0)
        part = Part(
            *(start, end, chunk.offset - _FRAME.size, chunk.length + _FRAME.size),
            is_chunk=True,
            is_cut=chunk.is_cut,
        )
        listed, channels = 0, set[int]()
        record = next(records, None)
        while record is not None and record.opcode == _MESSAGE_INDEX:
            self._file.seek(record.offset)
            head = self._file.read(min(record.length, _MESSAGE_INDEX_HEAD.size))
            if len(head) == _MESSAGE_INDEX_HEAD.size:
                channel, size = _MESSAGE_INDEX_HEAD.unpack(head)
                channels.add(channel)
                listed += min(size, record.length) // _MESSAGE_INDEX_ENTRY
            record = next(records, None)
        if listed and channels <= self.channels.keys() and start <= end:
            self._add_part(part, listed)
            return record
        try:
            self._look_into(part)
        except Unreadable as error:
            if not part.is_cut:  # That has its own fault.
                self._fault(f"the chunk at {part.offset} bytes: {error}")
        return record

    def _look_into(self, chunk: Part) -> None:
        """Take in what a chunk holds; what stands before damage counts."""
        start, end, count = 2**64, 0, 0
        try:
            for opcode, content in _records_of(self._file, chunk, self._budget):
                if opcode == _MESSAGE:
                    time = _MESSAGE_HEAD.unpack_from(content)[2]
                    start, end, count = min(start, time), max(end, time), count + 1
                elif opcode in (_SCHEMA, _CHANNEL):
                    self._parse(opcode, bytes(content))
        finally:
            if count:
                self._add_part(chunk._replace(start=start, end=end), count)


def read_index(file: BinaryIO, size: int, budget: Budget, fault: Callable[[str], None]) -> Index:
    """Return what a file holds. Its summary is not used: a file that was cut off has none."""
    index = Index(file, size, budget, fault)
    try:
        index.fill()
    except BudgetExceeded as error:
        fault(f"{error}: the rest is left out")
    except OSError as error:
        fault(f"{error.strerror}: the rest is left out")
    return index


def messages_of(
    file: BinaryIO, part: Part, channels: Mapping[int, object], budget: Budget
) -> Iterator[tuple[int, int, bytes]]:
    """Yield channel, log time and content of messages; raise Unreadable where the damage begins."""
    for opcode, content in _records_of(file, part, budget):
        if opcode == _MESSAGE:
            channel, _, time, _ = _MESSAGE_HEAD.unpack_from(content)
            if channel in channels:
                yield channel, time, bytes(content[_MESSAGE_HEAD.size :])


def _records_of(file: BinaryIO, part: Part, budget: Budget) -> Iterator[tuple[int, memoryview]]:
    """Yield opcode and content of each record in a part; raise Unreadable where damage begins."""
    data = _read_part(file, part, budget)
    view = memoryview(data)
    for opcode, offset, length, _ in _records(BytesIO(data), 0, len(data), budget):
        if opcode == _CUT or (opcode == _MESSAGE and length < _MESSAGE_HEAD.size):
            raise Unreadable
        yield opcode, view[offset : offset + length]


def _records(file: BinaryIO, offset: int, end: int, budget: Budget) -> Iterator[_Record]:
    """Yield each record; where none can be, the rest if it is of a chunk, then one that is _CUT."""
    while offset < end:
        budget.spend(records=1)
        file.seek(offset)
        head = file.read(_FRAME.size) if end - offset >= _FRAME.size else b""
        opcode, length = _FRAME.unpack(head) if len(head) == _FRAME.size else (_CUT, 0)
        content, left = offset + _FRAME.size, end - offset - _FRAME.size
        if opcode == _CUT or length > left:
            if opcode == _CHUNK:
                yield _Record(_CHUNK, content, left, is_cut=True)
            yield _Record(_CUT, offset, 0)
            return
        yield _Record(opcode, content, length)
        offset = content + length


def _read_part(file: BinaryIO, part: Part, budget: Budget) -> bytes:
    """Return the records of a part, unpacked if it is a chunk. The file may have changed."""
    if part.size > MAX_RECORD + _FRAME.size:
        raise Unreadable(f"larger than {MAX_RECORD // 10**6} MB")
    file.seek(part.offset)
    budget.spend(size=part.size)
    if not part.is_chunk:
        return file.read(part.size)
    head = file.read(_FRAME.size)
    opcode, length = _FRAME.unpack(head) if len(head) == _FRAME.size else (_CUT, 0)
    size = part.size - _FRAME.size
    if opcode != _CHUNK or (length != size and not part.is_cut):
        raise Unreadable
    return _unpack(file.read(size), budget, is_cut=part.is_cut)


def _unpack(content: bytes, budget: Budget, *, is_cut: bool) -> bytes:
    """Return the records of a chunk; those of one that is cut are not checked by size and CRC."""
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk

    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(content)))
        del content
    except Exception:  # Of many kinds: struct's, mcap's, UnicodeDecodeError.
        raise Unreadable from None
    size = chunk.uncompressed_size
    if size > MAX_RECORD:
        raise Unreadable(f"larger than {MAX_RECORD // 10**6} MB")
    try:
        data = _unpacked(chunk.compression, chunk.data, size + 1)
    except Unreadable:
        raise
    except ImportError as error:
        package = str(error.name).partition(".")[0]
        raise Unreadable(f"compressed: pip install {package} reads it") from None
    except Exception:  # Of many kinds: ZstdError, RuntimeError, EOFError.
        raise Unreadable from None
    budget.spend(size=len(data))
    crc = chunk.uncompressed_crc  # 0: the writer left it out.
    if not is_cut and (len(data) != size or (crc and zlib.crc32(data) != crc)):
        raise Unreadable
    return data[:size]


def _unpacked(compression: str, data: bytes, most: int) -> bytes:
    """Unpack at most so many bytes; mcap's own functions unpack without a bound."""
    if not compression:
        return data
    if compression == "zstd":
        import zstandard

        with zstandard.ZstdDecompressor(max_window_size=_WINDOW).stream_reader(data) as reader:
            return reader.read(most)
    if compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

        found: bytes = LZ4FrameDecompressor().decompress(data, max_length=most)
        return found
    raise Unreadable(f"compressed by {compression}, which is not known here")
