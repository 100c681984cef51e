"""Messages that are read, and not decoded yet: of some topics, within a time, in its order."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from archo_tui.errors import ArchoError
from archo_tui.replay import bag_paths
from archo_tui.replay.chunks import TooMuch, Unreadable, Work, records
from archo_tui.replay.faults import Faults
from archo_tui.replay.mcap_index import Piece
from archo_tui.replay.walk import MESSAGE, MESSAGE_HEAD, read

MOST_MESSAGES = 500_000  # at a time
MOST_BYTES = 100_000_000  # at a time, encoded
_LARGEST = 4_000_000  # bytes of a message, which take seconds to decode


class Topic(NamedTuple):
    """What a channel of a file means here."""

    name: str
    kind: Any  # the installed class


class Part(NamedTuple):
    """A piece, and the file that it is of."""

    piece: Piece
    path: Path
    topics: Mapping[int, Topic]  # by the number of the channel


class Held(NamedTuple):
    """One message."""

    time: int  # ns since the epoch
    place: tuple[int, int]  # number of its part, bytes within that: the order at the same time
    topic: Topic
    data: bytes


def held(
    parts: Sequence[Part], begin: float, end: float, wanted: Container[str], faults: Faults
) -> list[Held]:
    """All of them, or as many as may be held at a time. `parts` are in the order of time."""
    found: list[Held] = []
    work, left = Work(), MOST_BYTES
    chosen: dict[Path, dict[int, Topic]] = {}
    for number, part in enumerate(parts):
        if part.piece.start / 1e9 > end:
            break
        if part.path not in chosen:
            topics = part.topics.items()
            chosen[part.path] = {n: topic for n, topic in topics if topic.name in wanted}
        if part.piece.end / 1e9 < begin or not chosen[part.path]:
            continue
        try:
            with bag_paths.opened(part.path) as file:
                for one in _of_part(file, part.piece, number, chosen[part.path], work, faults):
                    if begin <= one.time / 1e9 <= end:
                        left -= len(one.data)
                        if left < 0 or len(found) == MOST_MESSAGES:
                            most = f"{MOST_MESSAGES:,} messages or {MOST_BYTES // 10**6} MB"
                            raise TooMuch(f"more than {most} at a time")
                        found.append(one)
        except TooMuch as error:
            faults.add(f"{error}: the rest is left out")
            break
        except Unreadable as error:
            if not part.piece.cut:  # that is said
                faults.add(f"{part.path.name}: the chunk at {part.piece.place} bytes: {error}")
        except ArchoError as error:
            faults.add(str(error))
        except OSError as error:
            faults.add(f"{part.path.name}: {error.strerror}")
    found.sort(key=itemgetter(0, 1))
    return found


def _of_part(
    file: BinaryIO,
    piece: Piece,
    number: int,
    topics: Mapping[int, Topic],
    work: Work,
    faults: Faults,
) -> Iterator[Held]:
    """The messages of these channels. Raises OSError, Unreadable and TooMuch."""
    data = read(file, piece, work)
    for opcode, place, end in records(data, work):
        if opcode != MESSAGE:
            continue
        if end - place < MESSAGE_HEAD.size:
            raise Unreadable("damaged")
        channel, _, time, _ = MESSAGE_HEAD.unpack_from(data, place)
        if channel not in topics:
            continue
        topic, where = topics[channel], (number, place)
        if end - place > _LARGEST:
            faults.add_message(topic.name, where, f"larger than {_LARGEST // 10**6} MB")
            continue
        yield Held(time, where, topic, data[place + MESSAGE_HEAD.size : end])
