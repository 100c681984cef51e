"""The records inside of a chunk, and what reading may cost, whatever a file says about itself."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from io import BytesIO
from struct import Struct

LARGEST = 64_000_000  # bytes of a record that is held, and of a chunk that is unpacked
_WINDOW = 2**26  # bytes that zstd may look back; its writers ask for 8 MB at most
_MOST_RECORDS = 3_000_000  # of one pass: some seconds
_MOST_BYTES = 4_000_000_000  # of one pass, in the file and unpacked: some seconds

FRAME = Struct("<BQ")  # opcode and length, in front of each record


class Unreadable(Exception):
    """A part of a file that cannot be read, and why."""


class TooMuch(Exception):
    """A pass over a recording costs more than anybody would wait for."""


class Work:
    """What one pass over a recording may cost."""

    def __init__(self) -> None:
        self._records, self._bytes = _MOST_RECORDS, _MOST_BYTES

    def record(self) -> None:
        """One more. Raises TooMuch."""
        self._records -= 1
        if self._records < 0:
            raise TooMuch(f"more than {_MOST_RECORDS:,} records")

    def read(self, count: int) -> None:
        """So many bytes more, of the file or unpacked. Raises TooMuch."""
        self._bytes -= count
        if self._bytes < 0:
            raise TooMuch(f"more than {_MOST_BYTES // 10**9} GB")


def records(data: bytes, work: Work) -> Iterator[tuple[int, int, int]]:
    """Opcode, begin and end of each record in it.

    Raises Unreadable behind the last one that is whole, where others should be; and TooMuch.
    """
    place = 0
    while len(data) - place >= FRAME.size:
        work.record()
        opcode, length = FRAME.unpack_from(data, place)
        place += FRAME.size
        if opcode == 0 or length > len(data) - place:
            raise Unreadable("damaged")
        yield opcode, place, place + length
        place += length
    if place < len(data):
        raise Unreadable("damaged")


def unpacked(content: bytes, work: Work, *, cut: bool) -> bytes:
    """The records of a chunk, of one that is cut off as many as there are.

    Raises Unreadable for one that is damaged or too large; and TooMuch.
    """
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk

    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(content)))
        del content
    except Exception:  # of many kinds: struct's, mcap's, of text
        raise Unreadable("damaged") from None
    size = chunk.uncompressed_size
    if size > LARGEST:
        raise Unreadable(f"larger than {LARGEST // 10**6} MB")
    if chunk.compression == "zstd":
        data = _zstd(chunk.data, size + 1)
    elif chunk.compression == "lz4":
        data = _lz4(chunk.data, size + 1)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise Unreadable(f"compressed by {chunk.compression}, which is not known here")
    work.read(len(data))
    if cut:
        return data[:size]
    crc = chunk.uncompressed_crc  # 0: the writer has left it out
    if len(data) != size or (crc and zlib.crc32(data) != crc):
        raise Unreadable("damaged")
    return data


def _zstd(data: bytes, most: int) -> bytes:
    """At most so many bytes of it."""
    try:
        import zstandard
    except ImportError:
        raise Unreadable("compressed: pip install zstandard reads it") from None
    try:
        decompressor = zstandard.ZstdDecompressor(max_window_size=_WINDOW)
        with decompressor.stream_reader(data) as reader:
            return reader.read(most)
    except zstandard.ZstdError:
        raise Unreadable("damaged") from None


def _lz4(data: bytes, most: int) -> bytes:
    """At most so many bytes of it."""
    try:
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]
    except ImportError:
        raise Unreadable("compressed: pip install lz4 reads it") from None
    try:
        found: bytes = LZ4FrameDecompressor().decompress(data, max_length=most)
    except (RuntimeError, EOFError, ValueError):
        raise Unreadable("damaged") from None
    return found
