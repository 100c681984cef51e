"""A reader of MCAP files from their beginning, which also reads files that were cut off.

mcap's own StreamReader does not fit: it loads every chunk instead of seeking over it, tells no
offsets, ends at the first damaged record, and reads 10 GB of zeros as records of length 0.
"""

from __future__ import annotations

from struct import Struct
from typing import BinaryIO

from archo_tui.replay.chunks import (
    FRAME,
    MAX_RECORD,
    ReadBudget,
    Unreadable,
    decompress_chunk,
    iter_records,
)
from archo_tui.replay.mcap_index import MAX_ROBOT_FILE, ROBOT_ATTACHMENT, Index, MessageRange

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX = 1, 2, 3, 4, 5, 6, 7
ATTACHMENT = 9
_END_RECORDS = ((15, 4), (FOOTER, 20))  # Opcode and length of the records after all messages.
MESSAGE_HEAD = Struct("<HIQQ")  # Channel, sequence, log time, publish time.
_TIMES = Struct("<QQ")
_INDEX = Struct("<HI")  # Of a message index: channel, bytes that follow.
_ENTRY_BYTES = 16  # Of each message in a message index.
_MAX_METADATA = 1_000_000  # The end of a larger record, say a channel's metadata, is not read.
_MAX_RUN = 1_000_000  # Bytes of messages outside of chunks in one range.
_NAME_END = 16 + 4 + len(ROBOT_ATTACHMENT)  # Offset at which the name of that attachment ends.


class LinearReader:
    """A pass over a file from its beginning that fills an index.

    It skips the content of a chunk if the message index behind the chunk tells enough. `run` reads
    all up to the end of the messages; `read_record_at` reads a single record.
    """

    def __init__(self, file: BinaryIO, size: int, index: Index, budget: ReadBudget) -> None:
        self._file, self._size = file, size
        self._index, self._budget, self._fault = index, budget, index.fault
        self._chunk: MessageRange | None = None  # The chunk whose message index is being read.
        self._channels: set[int] = set()  # The channels that the message index names.
        self._count = 0  # The messages that it counts.
        # Messages outside of chunks that follow each other, as far as they are read.
        self._open_run: MessageRange | None = None

    def run(self) -> None:
        """Fill the index up to the end of the messages; report a cut or damaged end as a fault.

        Raises:
            OSError: The file cannot be read; the index holds what was found until then.
            BudgetExceeded: The budget is used up; the index holds what was found until then.
        """
        try:
            self._read_records()
        finally:
            self._end_run()
        self._end_chunk()

    def _read_records(self) -> None:
        """Read the head of each record up to the end of the messages, or to where the file is cut.

        A cut is reported; the readable part of a cut chunk is kept.
        """
        offset = len(MAGIC)
        while True:
            self._budget.count_record()
            self._file.seek(offset)
            head = self._file.read(FRAME.size)
            if len(head) < FRAME.size:
                self._report_cut(offset)
                return
            opcode, length = FRAME.unpack(head)
            left = self._size - offset - FRAME.size
            if opcode == 0 or length > left:
                if opcode == CHUNK:
                    self._begin_chunk(offset, left, is_cut=True)
                self._report_cut(offset)
                return
            if (opcode, length) in _END_RECORDS:
                return
            self._on_record(opcode, offset, length)
            offset += FRAME.size + length

    def _report_cut(self, offset: int) -> None:
        self._fault(f"cut off or damaged after {offset} bytes: what stands before is read")

    def _on_record(self, opcode: int, offset: int, length: int) -> None:
        """Take a record into the index, or begin a chunk with it.

        Any record but a message or a message index ends the chunk before it. Records of no use here
        are ignored.
        """
        if opcode == MESSAGE:
            self._on_message(offset, length)
            return
        if opcode == MESSAGE_INDEX:
            self._on_message_index(length)
            return
        self._end_chunk()
        if opcode == CHUNK:
            self._begin_chunk(offset, length, is_cut=False)
        elif opcode == ATTACHMENT:
            self._file.seek(offset + FRAME.size)
            self._on_attachment(length)
        elif opcode in _HANDLERS:
            self._file.seek(offset + FRAME.size)
            self._add_metadata(opcode, self._read(min(length, _MAX_METADATA)))

    def _add_metadata(self, opcode: int, content: bytes) -> None:
        _HANDLERS[opcode](self._index, content)

    def _read(self, count: int) -> bytes:
        self._budget.count_bytes(count)
        return self._file.read(count)

    def _on_message(self, offset: int, length: int) -> None:
        """Add a message outside of chunks to the range that it continues, or to a new one.

        A message that is damaged or too large is reported and left out.
        """
        head = self._file.read(min(length, MESSAGE_HEAD.size))
        if len(head) < MESSAGE_HEAD.size or length > MAX_RECORD:
            self._fault("messages that are damaged or too large are left out")
            return
        time = MESSAGE_HEAD.unpack(head)[2]
        self._index.add_times(time, time, 1)
        size, known = FRAME.size + length, self._open_run
        if known and known.size < _MAX_RUN and known.offset + known.size == offset:
            start, end = min(known.start, time), max(known.end, time)
            self._open_run = MessageRange(start, end, known.offset, known.size + size, False)
            return
        self._end_run()
        self._open_run = MessageRange(time, time, offset, size, False)

    def _end_run(self) -> None:
        """Add to the index the open range of messages outside of chunks, if there is one."""
        if self._open_run:
            self._index.add_range(self._open_run)
        self._open_run = None

    def _begin_chunk(self, offset: int, length: int, *, is_cut: bool) -> None:
        """End the chunk before, and remember this one until the message index behind it is read.

        Args:
            offset: The offset of the chunk's record in the file.
            length: The bytes of its content that are in the file.
            is_cut: True if the file ends within it.
        """
        self._end_chunk()
        self._file.seek(offset + FRAME.size)
        times = self._file.read(_TIMES.size)
        start, end = _TIMES.unpack(times) if len(times) == _TIMES.size else (0, 0)
        self._chunk = MessageRange(start, end, offset, FRAME.size + length, True, is_cut)
        self._channels, self._count = set(), 0

    def _on_message_index(self, length: int) -> None:
        """Note the channel of a message index, and count the messages that it lists."""
        head = self._file.read(min(length, _INDEX.size))
        if len(head) == _INDEX.size:
            channel, size = _INDEX.unpack(head)
            self._channels.add(channel)
            self._count += min(size, length) // _ENTRY_BYTES

    def _end_chunk(self) -> None:
        """Add the remembered chunk, if any, to the index.

        It is decompressed if its message index does not tell enough; if that fails, the chunk is
        reported and left out.
        """
        chunk, self._chunk = self._chunk, None
        if chunk is None:
            return
        described = self._channels <= self._index.channels.keys()
        if self._count and described and chunk.start <= chunk.end:
            self._index.add_times(chunk.start, chunk.end, self._count)
            self._index.add_range(chunk)
            return
        try:
            self._scan_chunk(chunk)
        except Unreadable as error:
            if not chunk.is_cut:  # `_report_cut` has reported it already.
                self._fault(f"the chunk at {chunk.offset} bytes: {error}")

    def _scan_chunk(self, chunk: MessageRange) -> None:
        """Decompress a chunk, and add it to the index with its channels, times and message count.

        A chunk without messages is not added.

        Raises:
            Unreadable: The chunk is damaged; the messages before the damage are in the index.
        """
        start, end, count = 2**64, 0, 0
        data = read_range(self._file, chunk, self._budget)
        try:
            for opcode, offset, behind in iter_records(data, self._budget):
                if opcode == MESSAGE and behind - offset >= MESSAGE_HEAD.size:
                    time = MESSAGE_HEAD.unpack_from(data, offset)[2]
                    start, end, count = min(start, time), max(end, time), count + 1
                elif opcode in (SCHEMA, CHANNEL):
                    self._add_metadata(opcode, data[offset:behind])
        finally:
            if count:
                self._index.add_times(start, end, count)
                self._index.add_range(chunk._replace(start=start, end=end))

    def read_record_at(self, opcode: int, offset: int) -> None:
        """Read a single record into the index; do nothing if it has another opcode or is not whole.

        Raises:
            OSError: The file cannot be read.
            BudgetExceeded: The budget is used up.
        """
        self._file.seek(min(offset, self._size))
        head = self._file.read(FRAME.size)
        found, length = FRAME.unpack(head) if len(head) == FRAME.size else (0, 0)
        if found == opcode and length <= self._size - offset - FRAME.size:
            self._on_record(opcode, offset, length)

    def _on_attachment(self, length: int) -> None:
        """Read the attachment at the file's position into the index, if it is the robot file.

        A robot file that is too large is reported and left out.
        """
        name = self._file.read(min(length, _NAME_END))
        if name[16:] != len(ROBOT_ATTACHMENT).to_bytes(4, "little") + ROBOT_ATTACHMENT.encode():
            return
        if length > MAX_ROBOT_FILE:
            self._fault(f"{ROBOT_ATTACHMENT} is left out: larger than {MAX_ROBOT_FILE // 10**6} MB")
            return
        self._index.add_robot(name + self._read(length - len(name)))


_HANDLERS = {HEADER: Index.add_header, SCHEMA: Index.add_schema, CHANNEL: Index.add_channel}


def read_range(file: BinaryIO, messages: MessageRange, budget: ReadBudget) -> bytes:
    """Return the records of a range as bytes, decompressed if it is a chunk.

    Raises:
        OSError: The file cannot be read.
        Unreadable: The range is too large, or it is a chunk that is damaged or compressed by a
            method that is unknown or not installed.
        BudgetExceeded: The budget is used up.
    """
    if messages.size > MAX_RECORD + FRAME.size:
        raise Unreadable(f"larger than {MAX_RECORD // 10**6} MB")
    file.seek(messages.offset)
    budget.count_bytes(messages.size)
    if not messages.is_chunk:
        return file.read(messages.size)
    head = file.read(FRAME.size)
    opcode, length = FRAME.unpack(head) if len(head) == FRAME.size else (0, 0)
    size = messages.size - FRAME.size  # Below 0 if the file ended within the frame.
    if opcode != CHUNK or size < 0 or (length != size and not messages.is_cut):
        raise Unreadable("damaged")
    return decompress_chunk(file.read(size), budget, is_cut=messages.is_cut)
