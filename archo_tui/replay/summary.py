"""Reads what stands at the end of an MCAP file about all of it: quick for a large file, too."""

from __future__ import annotations

import zlib
from struct import Struct
from typing import BinaryIO

from archo_tui.replay.chunks import LARGEST, Unreadable, Work, records
from archo_tui.replay.mcap_index import Index, Piece
from archo_tui.replay.walk import ATTACHMENT, CHANNEL, FOOTER, HEADER, MAGIC, SCHEMA, Walk

_FOOTER = Struct("<BQQQI8s")  # frame; where the summary and its offsets begin; CRC; magic
_CHECKED = 1 + 3 * 8  # bytes of it that its CRC covers, behind the summary
_CHUNK_INDEX, _ATTACHMENT_INDEX, _STATISTICS = 8, 10, 11
_CHUNK_HEAD = Struct("<QQQQ")  # first and last time, place, size
_ATTACHED = Struct("<QQ")  # place, size
_COUNTS = Struct("<QHIIIIQQ")


def read_summary(file: BinaryIO, size: int, index: Index, work: Work) -> bool:
    """Fill the index from it; False where it is missing, damaged or does not say enough.

    The index is then of no use. Raises OSError and TooMuch.
    """
    data = _summary(file, size)
    if data is None:
        return False
    chunks: dict[int, Piece] = {}
    attached: list[tuple[int, int]] = []
    counts = None
    try:
        for opcode, begin, end in records(data, work):
            if opcode == SCHEMA:
                index.add_schema(data[begin:end])
            elif opcode == CHANNEL:
                index.add_channel(data[begin:end])
            elif opcode == _STATISTICS and end - begin >= _COUNTS.size:
                counts = _COUNTS.unpack_from(data, begin)
            elif opcode == _CHUNK_INDEX and end - begin >= _CHUNK_HEAD.size:
                start, last, place, length = _CHUNK_HEAD.unpack_from(data, begin)
                chunks[place] = Piece(start, last, place, length, True)
            elif opcode == _ATTACHMENT_INDEX and end - begin >= _ATTACHED.size:
                attached.append(_ATTACHED.unpack_from(data, begin))
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
    if any(piece.place + piece.size > size for piece in chunks.values()):
        return False
    if messages:
        index.add_times(start, last, messages)
    for piece in chunks.values():
        index.add_piece(piece)
    _read_beside(file, size, index, attached, work)
    return True


def _summary(file: BinaryIO, size: int) -> bytes | None:
    """The records of it, when they are whole."""
    end = size - _FOOTER.size
    if end < len(MAGIC):
        return None
    file.seek(end)
    foot = file.read(_FOOTER.size)
    if len(foot) < _FOOTER.size:
        return None
    opcode, length, start, _, crc, magic = _FOOTER.unpack(foot)
    if (opcode, length, magic) != (FOOTER, 20, MAGIC) or not 0 < end - start <= LARGEST:
        return None
    file.seek(start)
    data = file.read(end - start)
    if crc and zlib.crc32(foot[:_CHECKED], zlib.crc32(data)) != crc:  # 0: left out
        return None
    return data


def _read_beside(
    file: BinaryIO, size: int, index: Index, attached: list[tuple[int, int]], work: Work
) -> None:
    """The header and the robot file, which are not in the summary."""
    walk = Walk(file, size, index, work)
    for opcode, place in [(HEADER, len(MAGIC)), *((ATTACHMENT, place) for place, _ in attached)]:
        walk.one(opcode, place)
