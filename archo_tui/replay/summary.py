"""A reader of the summary section at the end of an MCAP file, which is quick for large files."""

from __future__ import annotations

import zlib
from struct import Struct
from typing import BinaryIO

from archo_tui.replay.chunks import MAX_RECORD, ReadBudget, Unreadable, iter_records
from archo_tui.replay.linear_reader import (
    ATTACHMENT,
    CHANNEL,
    FOOTER,
    HEADER,
    MAGIC,
    SCHEMA,
    LinearReader,
)
from archo_tui.replay.mcap_index import Index, MessageRange

_FOOTER = Struct("<BQQQI8s")  # Frame, start of summary and of offsets, CRC, magic.
_CRC_BYTES = 1 + 3 * 8  # Bytes of the footer that its CRC covers besides the summary.
_CHUNK_INDEX, _ATTACHMENT_INDEX, _STATISTICS = 8, 10, 11
_CHUNK_HEAD = Struct("<QQQQ")  # First and last time, offset, size.
_ATTACHMENT_HEAD = Struct("<QQ")  # Offset, size.
_STATISTICS_RECORD = Struct("<QHIIIIQQ")


def read_summary(file: BinaryIO, size: int, index: Index, budget: ReadBudget) -> bool:
    """Fill the index from the summary, the header and the attached robot file.

    Parts that are damaged are reported by the index.

    Returns:
        True if the index is filled. False if the summary is missing, damaged or incomplete; the
        index may hold a part of it then, and is of no use.

    Raises:
        OSError: The file cannot be read.
        BudgetExceeded: The budget is used up.
    """
    data = _summary_section(file, size)
    if data is None:
        return False
    chunks: dict[int, MessageRange] = {}
    attached: list[tuple[int, int]] = []
    counts = None
    try:
        for opcode, begin, end in iter_records(data, budget):
            if opcode == SCHEMA:
                index.add_schema(data[begin:end])
            elif opcode == CHANNEL:
                index.add_channel(data[begin:end])
            elif opcode == _STATISTICS and end - begin >= _STATISTICS_RECORD.size:
                counts = _STATISTICS_RECORD.unpack_from(data, begin)
            elif opcode == _CHUNK_INDEX and end - begin >= _CHUNK_HEAD.size:
                start, last, offset, length = _CHUNK_HEAD.unpack_from(data, begin)
                chunks[offset] = MessageRange(start, last, offset, length, True)
            elif opcode == _ATTACHMENT_INDEX and end - begin >= _ATTACHMENT_HEAD.size:
                attached.append(_ATTACHMENT_HEAD.unpack_from(data, begin))
    except Unreadable:
        return False
    if counts is None:
        return False
    messages, schemas, channels, attachments, _, chunk_count, start, last = counts
    found = (len(index.schemas), len(index.channels), len(attached), len(chunks))
    if found != (schemas, channels, attachments, chunk_count) or (
        messages and not (chunks and start <= last)
    ):
        return False
    if any(chunk.offset + chunk.size > size for chunk in chunks.values()):
        return False
    if messages:
        index.add_times(start, last, messages)
    for chunk in chunks.values():
        index.add_range(chunk)
    _read_header_and_robot(file, size, index, attached, budget)
    return True


def _summary_section(file: BinaryIO, size: int) -> bytes | None:
    """Return the records of the summary, or None if it is missing, damaged or above MAX_RECORD."""
    end = size - _FOOTER.size
    if end < len(MAGIC):
        return None
    file.seek(end)
    foot = file.read(_FOOTER.size)
    if len(foot) < _FOOTER.size:
        return None
    opcode, length, start, _, crc, magic = _FOOTER.unpack(foot)
    if (opcode, length, magic) != (FOOTER, 20, MAGIC) or not 0 < end - start <= MAX_RECORD:
        return None
    file.seek(start)
    data = file.read(end - start)
    if crc and zlib.crc32(foot[:_CRC_BYTES], zlib.crc32(data)) != crc:  # 0: the writer left it out.
        return None
    return data


def _read_header_and_robot(
    file: BinaryIO, size: int, index: Index, attached: list[tuple[int, int]], budget: ReadBudget
) -> None:
    """Read into the index the header and the robot file, which the summary only points to.

    Args:
        file: The file.
        size: Its size, in bytes.
        index: The index.
        attached: Offset and size of each attachment.
        budget: The budget that their bytes count against.
    """
    reader = LinearReader(file, size, index, budget)
    for opcode, offset in [(HEADER, len(MAGIC)), *((ATTACHMENT, offset) for offset, _ in attached)]:
        reader.read_record_at(opcode, offset)
