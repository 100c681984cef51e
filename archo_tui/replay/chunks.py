"""The records inside an MCAP chunk, and the budget that bounds the reading of a file.

The format is specified at https://mcap.dev/spec.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from io import BytesIO
from struct import Struct

MAX_RECORD = 64_000_000  # Bytes of a record in memory, or of a decompressed chunk.
_WINDOW = 2**26  # Bytes; zstd's own writers ask for 8 MB at most.
_MAX_RECORDS = 3_000_000  # Of one pass, which takes some seconds.
_MAX_BYTES = 4_000_000_000  # Read and decompressed in one pass, in some seconds.

FRAME = Struct("<BQ")  # Opcode and length, before each record.


class Unreadable(Exception):
    """The error for a part of a file that cannot be read; the rest may be readable.

    Its text is the reason, in a few words.
    """


class BudgetExceeded(Exception):
    """The error that ends a pass over a recording when its ReadBudget is used up."""


class ReadBudget:
    """The records and bytes that one pass over a recording may still read: 3 million and 4 GB."""

    def __init__(self) -> None:
        self._records, self._bytes = _MAX_RECORDS, _MAX_BYTES

    def count_record(self) -> None:
        """Take a record off the budget.

        Raises:
            BudgetExceeded: No record was left in the budget.
        """
        self._records -= 1
        if self._records < 0:
            raise BudgetExceeded(f"more than {_MAX_RECORDS:,} records")

    def count_bytes(self, count: int) -> None:
        """Take bytes off the budget, whether read from the file or decompressed.

        Raises:
            BudgetExceeded: More bytes were taken than the budget had.
        """
        self._bytes -= count
        if self._bytes < 0:
            raise BudgetExceeded(f"more than {_MAX_BYTES // 10**9} GB")


def iter_records(data: bytes, budget: ReadBudget) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of each record in the bytes.

    Begin and end are the offsets of the record's content, behind its opcode and length.

    Raises:
        Unreadable: At a record with opcode 0 or without its end; those before it were yielded.
        BudgetExceeded: The budget is used up.
    """
    offset = 0
    while len(data) - offset >= FRAME.size:
        budget.count_record()
        opcode, length = FRAME.unpack_from(data, offset)
        offset += FRAME.size
        if opcode == 0 or length > len(data) - offset:
            raise Unreadable("damaged")
        yield opcode, offset, offset + length
        offset += length
    if offset < len(data):
        raise Unreadable("damaged")


def decompress_chunk(content: bytes, budget: ReadBudget, *, is_cut: bool) -> bytes:
    """Return the records of a chunk, decompressed, after a check of their size and, if given, CRC.

    Args:
        content: The chunk record without its frame.
        budget: The budget that the decompressed bytes count against.
        is_cut: True if the file ends within the chunk: the bytes that are there are returned
            unchecked.

    Raises:
        Unreadable: The chunk is damaged, decompressed larger than MAX_RECORD, or compressed by a
            method that is unknown or not installed.
        BudgetExceeded: The budget is used up.
    """
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
    if chunk.compression == "zstd":
        data = _decompress_zstd(chunk.data, size + 1)
    elif chunk.compression == "lz4":
        data = _decompress_lz4(chunk.data, size + 1)
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise Unreadable(f"compressed by {chunk.compression}, which is not known here")
    budget.count_bytes(len(data))
    if is_cut:
        return data[:size]
    crc = chunk.uncompressed_crc  # 0: the writer left it out.
    if len(data) != size or (crc and zlib.crc32(data) != crc):
        raise Unreadable("damaged")
    return data


def _decompress_zstd(data: bytes, max_bytes: int) -> bytes:
    """Return the first `max_bytes` decompressed bytes.

    Raises:
        Unreadable: The data are damaged, or zstandard is not installed.
    """
    try:
        import zstandard
    except ImportError:
        raise Unreadable("compressed: pip install zstandard reads it") from None
    try:
        decompressor = zstandard.ZstdDecompressor(max_window_size=_WINDOW)
        with decompressor.stream_reader(data) as reader:
            return reader.read(max_bytes)
    except zstandard.ZstdError:
        raise Unreadable("damaged") from None


def _decompress_lz4(data: bytes, max_bytes: int) -> bytes:
    """Return the first `max_bytes` decompressed bytes.

    Raises:
        Unreadable: The data are damaged, or lz4 is not installed.
    """
    try:
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]
    except ImportError:
        raise Unreadable("compressed: pip install lz4 reads it") from None
    try:
        found: bytes = LZ4FrameDecompressor().decompress(data, max_length=max_bytes)
    except (RuntimeError, EOFError, ValueError):
        raise Unreadable("damaged") from None
    return found
