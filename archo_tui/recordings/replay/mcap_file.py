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
_ATTACHMENT = 9
_END_RECORDS = ((15, 4), (_FOOTER, 20))  # Opcode and length of the records after all messages.
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


class _Damaged(Unreadable):
    def __init__(self, offset: int, opcode: int = 0) -> None:
        super().__init__("damaged")
        self.offset, self.opcode = offset, opcode  # Of the record.


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

    def describe(self, size: int) -> None:
        """Take off a definition or channel of so many bytes, or raise Unreadable."""
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


class Index:
    """The index of a file, filled record by record; `fault` gets what is damaged or too large."""

    def __init__(self, budget: Budget, fault: Callable[[str], None]) -> None:
        self.profile = self.robot = ""
        self.channels: dict[int, Channel] = {}
        self.schemas: dict[int, Schema] = {}
        self.parts: list[Part] = []
        self.start, self.end, self.count = 2**64, 0, 0  # Times in ns, of all messages.
        self.fault, self._budget = fault, budget

    def add(self, opcode: int, content: bytes) -> None:
        """Take in a header, schema, channel or attachment; one whose id is known is ignored."""
        try:
            self._add(opcode, content)
        except Unreadable as error:
            self.fault(f"{_NAMES[opcode]} is left out: {error}")
        except Exception:  # Of many kinds: struct's, mcap's, UnicodeDecodeError.
            self.fault(f"{_NAMES[opcode]} is left out: damaged")

    def _add(self, opcode: int, content: bytes) -> None:
        from mcap import records
        from mcap.data_stream import ReadDataStream

        stream, number = ReadDataStream(BytesIO(content)), int.from_bytes(content[:2], "little")
        if opcode == _HEADER:
            self.profile = stream.read_prefixed_string()
        elif opcode == _SCHEMA and number not in self.schemas:
            self._budget.describe(len(content))
            self.schemas[number] = records.Schema.read(stream)
        elif opcode == _CHANNEL and number not in self.channels:
            self._budget.describe(len(content))
            self.channels[number] = records.Channel.read(stream)
        elif opcode == _ATTACHMENT and not self.robot:
            crc = int.from_bytes(content[-4:], "little")  # 0: the writer left it out.
            if crc and crc != zlib.crc32(content[:-4]):
                raise Unreadable("damaged")
            self.robot = records.Attachment.read(stream).data.decode()

    def add_part(self, part: Part) -> None:
        self._budget.spend(records=_PART)
        self.parts.append(part)

    def add_times(self, start: int, end: int, count: int) -> None:
        """Count messages, and widen the time of the file by their first and last log time."""
        self.start, self.end = min(self.start, start), max(self.end, end)
        self.count += count


def read_index(file: BinaryIO, size: int, budget: Budget, fault: Callable[[str], None]) -> Index:
    """Return what a file holds; the records between its chunks tell it, so few are unpacked.

    The summary at the end of a file is not used: it is missing in one that was cut off, and may
    lie. If the disk fails or the budget ends, what was found until then counts.
    """
    index = Index(budget, fault)
    try:
        _Scan(file, size, index, budget).run()
    except BudgetExceeded as error:
        fault(f"{error}: the rest is left out")
    except OSError as error:
        fault(f"{error.strerror}: the rest is left out")
    return index


def messages_of(
    file: BinaryIO, part: Part, channels: Mapping[int, object], budget: Budget
) -> Iterator[tuple[int, int, int, bytes]]:
    """Yield channel, log time, offset in the part, and content of messages, as the file has them.

    Raises OSError, BudgetExceeded, or Unreadable behind the last message before the damage.
    """
    data = _read_part(file, part, budget)
    for opcode, offset, length in _records(BytesIO(data), 0, len(data), budget):
        if opcode == _MESSAGE:
            if length < _MESSAGE_HEAD.size:
                raise _Damaged(offset)
            channel, _, time, _ = _MESSAGE_HEAD.unpack_from(data, offset)
            if channel in channels:
                begin, end = offset + _MESSAGE_HEAD.size, offset + length
                yield channel, time, offset, data[begin:end]


def _records(
    file: BinaryIO, offset: int, end: int, budget: Budget
) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, and offset and length of the content, of each record; raise _Damaged at none.

    A record with opcode 0, as files of zeros have it, is none.
    """
    while offset < end:
        budget.spend(records=1)
        file.seek(offset)
        head = file.read(_FRAME.size) if end - offset >= _FRAME.size else b""
        if len(head) < _FRAME.size:
            raise _Damaged(offset)
        opcode, length = _FRAME.unpack(head)
        if opcode == 0 or length > end - offset - _FRAME.size:
            raise _Damaged(offset, opcode)
        offset += _FRAME.size
        yield opcode, offset, length
        offset += length


def _read_part(file: BinaryIO, part: Part, budget: Budget) -> bytes:
    """Return the records of a part, unpacked if it is a chunk. The file may have changed."""
    if part.size > MAX_RECORD + _FRAME.size:
        raise Unreadable(f"larger than {MAX_RECORD // 10**6} MB")
    file.seek(part.offset)
    budget.spend(size=part.size)
    if not part.is_chunk:
        return file.read(part.size)
    head = file.read(_FRAME.size)
    opcode, length = _FRAME.unpack(head) if len(head) == _FRAME.size else (0, 0)
    size = part.size - _FRAME.size  # Below 0 if the file ended within the frame.
    if opcode != _CHUNK or size < 0 or (length != size and not part.is_cut):
        raise _Damaged(part.offset)
    return _unpack(file.read(size), budget, is_cut=part.is_cut)


def _unpack(content: bytes, budget: Budget, *, is_cut: bool) -> bytes:
    """Return the records of a chunk; those of one that is cut are not checked by size and CRC."""
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk

    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(content)))
        del content
    except Exception:  # Of many kinds: struct's, mcap's, UnicodeDecodeError.
        raise Unreadable("damaged") from None
    size = chunk.uncompressed_size
    if size > MAX_RECORD:
        raise Unreadable(f"larger than {MAX_RECORD // 10**6} MB")
    if chunk.compression not in _UNPACKERS:
        raise Unreadable(f"compressed by {chunk.compression}, which is not known here")
    try:
        data = _UNPACKERS[chunk.compression](chunk.data, size + 1)
    except ImportError as error:
        package = str(error.name).partition(".")[0]
        raise Unreadable(f"compressed: pip install {package} reads it") from None
    except Exception:  # Of many kinds: ZstdError, RuntimeError, EOFError.
        raise Unreadable("damaged") from None
    budget.spend(size=len(data))
    crc = chunk.uncompressed_crc  # 0: the writer left it out.
    if not is_cut and (len(data) != size or (crc and zlib.crc32(data) != crc)):
        raise Unreadable("damaged")
    return data[:size]


def _unpack_zstd(data: bytes, most: int) -> bytes:
    import zstandard

    with zstandard.ZstdDecompressor(max_window_size=_WINDOW).stream_reader(data) as reader:
        return reader.read(most)


def _unpack_lz4(data: bytes, most: int) -> bytes:
    from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

    found: bytes = LZ4FrameDecompressor().decompress(data, max_length=most)
    return found


# mcap's own functions unpack without a bound.
_UNPACKERS: Mapping[str, Callable[[bytes, int], bytes]] = {
    "": lambda data, _: data,
    "zstd": _unpack_zstd,
    "lz4": _unpack_lz4,
}


class _Scan:
    """A pass over a file from its beginning, also over one that was cut off.

    A chunk whose message index tells enough is not unpacked.
    """

    def __init__(self, file: BinaryIO, size: int, index: Index, budget: Budget) -> None:
        self._file, self._size, self._index, self._budget = file, size, index, budget
        self._open: Part | None = None  # The chunk or run that the next records may belong to.
        self._listed = 0  # The messages that the message index of an open chunk lists,
        self._channels: set[int] = set()  # and their channels.

    def run(self) -> None:
        """Fill the index up to the end of the messages, or to where the file is cut."""
        records = _records(self._file, len(MAGIC), self._size, self._budget)
        try:
            for opcode, offset, length in records:
                if (opcode, length) in _END_RECORDS:
                    break
                self._take(opcode, offset, length)
            else:
                raise _Damaged(self._size)
        except _Damaged as cut:
            self._close()
            if cut.opcode == _CHUNK:
                self._open_chunk(cut.offset, self._size - cut.offset, is_cut=True)
            text = f"cut off or damaged after {cut.offset} bytes: what stands before is read"
            self._index.fault(text)
        finally:
            if self._open is not None and not self._open.is_chunk:
                self._close()
        self._close()

    def _take(self, opcode: int, offset: int, length: int) -> None:
        if opcode not in (_MESSAGE, _MESSAGE_INDEX):
            self._close()  # It may read a chunk, so only now:
        self._file.seek(offset)
        if opcode == _MESSAGE:
            self._on_message(offset - _FRAME.size, length)
        elif opcode == _MESSAGE_INDEX:
            self._on_message_index(length)
        elif opcode == _CHUNK:
            self._open_chunk(offset - _FRAME.size, length + _FRAME.size)
        elif opcode == _ATTACHMENT:
            self._on_attachment(length)
        elif opcode in _NAMES:
            self._index.add(opcode, self._read(min(length, _MAX_METADATA)))

    def _read(self, count: int) -> bytes:
        self._budget.spend(size=count)
        return self._file.read(count)

    def _on_message(self, offset: int, length: int) -> None:
        head = self._file.read(min(length, _MESSAGE_HEAD.size))
        if len(head) < _MESSAGE_HEAD.size or length > MAX_RECORD:
            self._index.fault("messages that are damaged or too large are left out")
            return
        time = _MESSAGE_HEAD.unpack(head)[2]
        self._index.add_times(time, time, 1)
        size, run = _FRAME.size + length, self._open
        if run and not run.is_chunk and run.size < _MAX_RUN and run.offset + run.size == offset:
            start, end = min(run.start, time), max(run.end, time)
            self._open = Part(start, end, run.offset, run.size + size, is_chunk=False)
            return
        self._close()
        self._open = Part(time, time, offset, size, is_chunk=False)

    def _on_message_index(self, length: int) -> None:
        head = self._file.read(min(length, _MESSAGE_INDEX_HEAD.size))
        if len(head) == _MESSAGE_INDEX_HEAD.size:
            channel, size = _MESSAGE_INDEX_HEAD.unpack(head)
            self._channels.add(channel)
            self._listed += min(size, length) // _MESSAGE_INDEX_ENTRY

    def _on_attachment(self, length: int) -> None:
        """Add the attachment with the robot file to the index; others are not read."""
        name = self._file.read(min(length, _NAME_END))
        if name[16:] != len(_ROBOT).to_bytes(4, "little") + _ROBOT.encode():
            return
        if length > _MAX_METADATA:
            self._index.fault(f"{_ROBOT} is left out: larger than {_MAX_METADATA // 10**6} MB")
            return
        self._index.add(_ATTACHMENT, name + self._read(length - len(name)))

    def _open_chunk(self, offset: int, size: int, *, is_cut: bool = False) -> None:
        self._file.seek(offset + _FRAME.size)
        times = self._file.read(_CHUNK_TIMES.size)
        start, end = _CHUNK_TIMES.unpack(times) if len(times) == _CHUNK_TIMES.size else (0, 0)
        self._open = Part(start, end, offset, size, True, is_cut)
        self._listed, self._channels = 0, set()

    def _close(self) -> None:
        """Add the open part to the index; a chunk without a full message index is unpacked."""
        part, self._open = self._open, None
        if part is None:
            return
        if not part.is_chunk:
            self._index.add_part(part)
            return
        is_described = self._listed and self._channels <= self._index.channels.keys()
        if is_described and part.start <= part.end:
            self._index.add_times(part.start, part.end, self._listed)
            self._index.add_part(part)
            return
        try:
            self._scan_chunk(part)
        except Unreadable as error:
            if not part.is_cut:  # That has its own fault.
                self._index.fault(f"the chunk at {part.offset} bytes: {error}")

    def _scan_chunk(self, chunk: Part) -> None:
        """Take in what a chunk holds; what stands before damage counts."""
        start, end, count = 2**64, 0, 0
        data = _read_part(self._file, chunk, self._budget)
        try:
            for opcode, at, length in _records(BytesIO(data), 0, len(data), self._budget):
                if opcode == _MESSAGE and length >= _MESSAGE_HEAD.size:
                    time = _MESSAGE_HEAD.unpack_from(data, at)[2]
                    start, end, count = min(start, time), max(end, time), count + 1
                elif opcode in (_SCHEMA, _CHANNEL):
                    self._index.add(opcode, data[at : at + length])
        finally:
            if count:
                self._index.add_times(start, end, count)
                self._index.add_part(chunk._replace(start=start, end=end))
