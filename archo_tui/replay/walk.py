"""Reads an MCAP file from its begin, record by record: also one that was cut off in writing.

mcap's own StreamReader does not fit: it loads every chunk instead of seeking over it, tells no
places, ends at the first damaged record, and reads 10 GB of zeros one record of length 0 at a time.
"""

from __future__ import annotations

from struct import Struct
from typing import BinaryIO

from archo_tui.replay.chunks import FRAME, LARGEST, Unreadable, Work, records, unpacked
from archo_tui.replay.mcap_index import MOST_ATTACHED, ROBOT, Index, Piece

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX = 1, 2, 3, 4, 5, 6, 7
ATTACHMENT = 9
_ENDS = ((15, 4), (FOOTER, 20))  # opcode and length of what stands behind all messages
MESSAGE_HEAD = Struct("<HIQQ")  # channel, sequence, log time and publish time, before the data
_TIMES = Struct("<QQ")
_INDEX = Struct("<HI")  # of a chunk's messages: channel, bytes that follow
_ENTRY = 16  # bytes in it for each message
_LARGEST_KEPT = 1_000_000  # bytes of a channel, say, whose metadata are not looked at
_STRETCH = 1_000_000  # bytes of messages outside of chunks that are read together
_NAMED = 16 + 4 + len(ROBOT)  # bytes of an attachment up to the end of that name


class Walk:
    """One pass over a file; it seeks over what is known by its head."""

    def __init__(self, file: BinaryIO, size: int, index: Index, work: Work) -> None:
        self._file, self._size = file, size
        self._index, self._work, self._fault = index, work, index.fault
        self._chunk: Piece | None = None  # whose own index follows
        self._channels: set[int] = set()  # which that names
        self._count = 0  # messages, by that
        self._stretch: Piece | None = None  # messages outside of chunks, as far as they are read

    def run(self) -> None:
        """Fill the index. Raises OSError and TooMuch; it holds what was found until then."""
        try:
            self._run()
        finally:
            self._end_stretch()
        self._end_chunk()

    def _run(self) -> None:
        place = len(MAGIC)
        while True:
            self._work.record()
            self._file.seek(place)
            head = self._file.read(FRAME.size)
            if len(head) < FRAME.size:
                self._cut(place)
                return
            opcode, length = FRAME.unpack(head)
            left = self._size - place - FRAME.size
            if opcode == 0 or length > left:
                if opcode == CHUNK:
                    self._begin_chunk(place, left, cut=True)
                self._cut(place)
                return
            if (opcode, length) in _ENDS:
                return
            self._take(opcode, place, length)
            place += FRAME.size + length

    def _cut(self, place: int) -> None:
        self._fault(f"cut off or damaged after {place} bytes: what stands before is read")

    def _take(self, opcode: int, place: int, length: int) -> None:
        if opcode == MESSAGE:
            self._message(place, length)
            return
        if opcode == MESSAGE_INDEX:
            self._message_index(length)
            return
        self._end_chunk()
        if opcode == CHUNK:
            self._begin_chunk(place, length, cut=False)
        elif opcode == ATTACHMENT:
            self._file.seek(place + FRAME.size)
            self._attachment(length)
        elif opcode in _KEPT:
            self._file.seek(place + FRAME.size)
            self._keep(opcode, self._read(min(length, _LARGEST_KEPT)))

    def _keep(self, opcode: int, content: bytes) -> None:
        _KEPT[opcode](self._index, content)

    def _read(self, count: int) -> bytes:
        self._work.read(count)
        return self._file.read(count)

    def _message(self, place: int, length: int) -> None:
        head = self._file.read(min(length, MESSAGE_HEAD.size))
        if len(head) < MESSAGE_HEAD.size or length > LARGEST:
            self._fault("messages that are damaged or too large are left out")
            return
        time = MESSAGE_HEAD.unpack(head)[2]
        self._index.add_times(time, time, 1)
        size, known = FRAME.size + length, self._stretch
        if known and known.size < _STRETCH and known.place + known.size == place:
            start, end = min(known.start, time), max(known.end, time)
            self._stretch = Piece(start, end, known.place, known.size + size, False)
            return
        self._end_stretch()
        self._stretch = Piece(time, time, place, size, False)

    def _end_stretch(self) -> None:
        if self._stretch:
            self._index.add_piece(self._stretch)
        self._stretch = None

    def _begin_chunk(self, place: int, length: int, *, cut: bool) -> None:
        self._end_chunk()
        self._file.seek(place + FRAME.size)
        times = self._file.read(_TIMES.size)
        start, end = _TIMES.unpack(times) if len(times) == _TIMES.size else (0, 0)
        self._chunk = Piece(start, end, place, FRAME.size + length, True, cut)
        self._channels, self._count = set(), 0

    def _message_index(self, length: int) -> None:
        head = self._file.read(min(length, _INDEX.size))
        if len(head) == _INDEX.size:
            channel, size = _INDEX.unpack(head)
            self._channels.add(channel)
            self._count += min(size, length) // _ENTRY

    def _end_chunk(self) -> None:
        """When all that follows a chunk about it has been read; it is opened if that is needed."""
        chunk, self._chunk = self._chunk, None
        if chunk is None:
            return
        described = self._channels <= self._index.channels.keys()
        if self._count and described and chunk.start <= chunk.end:
            self._index.add_times(chunk.start, chunk.end, self._count)
            self._index.add_piece(chunk)
            return
        try:
            self._open(chunk)
        except Unreadable as error:
            if not chunk.cut:  # that is said
                self._fault(f"the chunk at {chunk.place} bytes: {error}")

    def _open(self, chunk: Piece) -> None:
        start, end, count = 2**64, 0, 0
        data = read(self._file, chunk, self._work)
        try:
            for opcode, place, behind in records(data, self._work):
                if opcode == MESSAGE and behind - place >= MESSAGE_HEAD.size:
                    time = MESSAGE_HEAD.unpack_from(data, place)[2]
                    start, end, count = min(start, time), max(end, time), count + 1
                elif opcode in (SCHEMA, CHANNEL):
                    self._keep(opcode, data[place:behind])
        finally:
            if count:
                self._index.add_times(start, end, count)
                self._index.add_piece(chunk._replace(start=start, end=end))

    def one(self, opcode: int, place: int) -> None:
        """Take the one record there, if it is such. Raises OSError."""
        self._file.seek(min(place, self._size))
        head = self._file.read(FRAME.size)
        found, length = FRAME.unpack(head) if len(head) == FRAME.size else (0, 0)
        if found == opcode and length <= self._size - place - FRAME.size:
            self._take(opcode, place, length)

    def _attachment(self, length: int) -> None:
        """The one that begins where the file stands, behind its frame."""
        name = self._file.read(min(length, _NAMED))
        if name[16:] != len(ROBOT).to_bytes(4, "little") + ROBOT.encode():
            return
        if length > MOST_ATTACHED:
            self._fault(f"{ROBOT} is left out: larger than {MOST_ATTACHED // 10**6} MB")
            return
        self._index.add_robot(name + self._read(length - len(name)))


_KEPT = {HEADER: Index.add_header, SCHEMA: Index.add_schema, CHANNEL: Index.add_channel}


def read(file: BinaryIO, piece: Piece, work: Work) -> bytes:
    """The records of a piece. Raises OSError, Unreadable and TooMuch."""
    if piece.size > LARGEST + FRAME.size:
        raise Unreadable(f"larger than {LARGEST // 10**6} MB")
    file.seek(piece.place)
    work.read(piece.size)
    if not piece.is_chunk:
        return file.read(piece.size)
    head = file.read(FRAME.size)
    opcode, length = FRAME.unpack(head) if len(head) == FRAME.size else (0, 0)
    size = piece.size - FRAME.size  # below 0 where a bag that is still written ended in the head
    if opcode != CHUNK or size < 0 or (length != size and not piece.cut):
        raise Unreadable("damaged")
    return unpacked(file.read(size), work, cut=piece.cut)
