"""A reader of encoded messages from the ranges of a bag, sorted by time."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from archo_tui.errors import ArchoError
from archo_tui.replay import bag_paths
from archo_tui.replay.chunks import BudgetExceeded, ReadBudget, Unreadable, iter_records
from archo_tui.replay.faults import Faults
from archo_tui.replay.linear_reader import MESSAGE, MESSAGE_HEAD, read_range
from archo_tui.replay.mcap_index import MessageRange

MAX_MESSAGES = 500_000  # Of one call.
MAX_BYTES = 100_000_000  # Of one call, encoded.
_MAX_MESSAGE_BYTES = 4_000_000  # Of a message; decoding more takes seconds.


class Topic(NamedTuple):
    """A topic that can be decoded.

    Attributes:
        name: Its full name.
        message_class: The installed class.
    """

    name: str
    message_class: Any


class FileRange(NamedTuple):
    """A range of messages with its file.

    Attributes:
        messages: Where the range is in the file.
        path: The file.
        topics: The topics of the file that can be decoded, by channel id.
    """

    messages: MessageRange
    path: Path
    topics: Mapping[int, Topic]


class EncodedMessage(NamedTuple):
    """A message that is not decoded yet.

    Attributes:
        time: Its log time, in ns since the epoch.
        order: The number of its range in the bag and its offset in the range; they identify the
            message, and sort those of the same time.
        topic: Its topic.
        data: Its CDR bytes.
    """

    time: int
    order: tuple[int, int]
    topic: Topic
    data: bytes


class ReadMessages(NamedTuple):
    """The result of one reading.

    Attributes:
        messages: The messages, in the order of time.
        is_cut: True if a limit or the budget of a pass ended the reading: later ones are missing.
    """

    messages: list[EncodedMessage]
    is_cut: bool


def read_messages(
    ranges: Sequence[FileRange], begin: float, end: float, wanted: Container[str], faults: Faults
) -> ReadMessages:
    """Read the messages of some topics within a time.

    What cannot be read is left out. Not more than MAX_MESSAGES or MAX_BYTES are returned; the
    ranges after that are not read.

    Args:
        ranges: The ranges of the bag, sorted by their start.
        begin: Unix time of the first message, in s; itself included.
        end: Unix time of the last message, in s; itself included.
        wanted: The topics, by full names.
        faults: Receives what could not be read.
    """
    found: list[EncodedMessage] = []
    is_cut = False
    budget, left = ReadBudget(), MAX_BYTES
    channels: dict[Path, dict[int, Topic]] = {}
    for number, (messages, path, topics) in enumerate(ranges):
        if messages.start / 1e9 > end:
            break
        if path not in channels:
            channels[path] = {n: topic for n, topic in topics.items() if topic.name in wanted}
        if messages.end / 1e9 < begin or not channels[path]:
            continue
        try:
            with bag_paths.opened(path) as file:
                for message in _split_range(file, messages, number, channels[path], budget, faults):
                    if begin <= message.time / 1e9 <= end:
                        left -= len(message.data)
                        if left < 0 or len(found) == MAX_MESSAGES:
                            limit = f"{MAX_MESSAGES:,} messages or {MAX_BYTES // 10**6} MB"
                            raise BudgetExceeded(f"more than {limit} at a time")
                        found.append(message)
        except BudgetExceeded as error:
            faults.add(f"{error}: the rest is left out")
            is_cut = True
            break
        except Unreadable as error:
            if not messages.is_cut:  # The reader of the file has reported that already.
                faults.add(f"{path.name}: the chunk at {messages.offset} bytes: {error}")
        except ArchoError as error:
            faults.add(str(error))
        except OSError as error:
            faults.add(f"{path.name}: {error.strerror}")
    found.sort(key=itemgetter(0, 1))
    return ReadMessages(found, is_cut)


def _split_range(
    file: BinaryIO,
    messages: MessageRange,
    number: int,
    topics: Mapping[int, Topic],
    budget: ReadBudget,
    faults: Faults,
) -> Iterator[EncodedMessage]:
    """Yield the messages of some channels in a range, in the order of the file, of whatever time.

    Args:
        file: The file, which is open.
        messages: Where the range is.
        number: The number of the range in the bag, for the order of messages.
        topics: The wanted topics, by channel id.
        budget: The budget that the range counts against.
        faults: Receives the messages larger than 4 MB, which are left out.

    Raises:
        OSError: The file cannot be read.
        Unreadable: The range is damaged; the messages before the damage were yielded.
        BudgetExceeded: The budget is used up.
    """
    data = read_range(file, messages, budget)
    for opcode, start, end in iter_records(data, budget):
        if opcode != MESSAGE:
            continue
        if end - start < MESSAGE_HEAD.size:
            raise Unreadable("damaged")
        channel, _, time, _ = MESSAGE_HEAD.unpack_from(data, start)
        if channel not in topics:
            continue
        topic, order = topics[channel], (number, start)
        if end - start > _MAX_MESSAGE_BYTES:
            faults.add_message(topic.name, order, f"larger than {_MAX_MESSAGE_BYTES // 10**6} MB")
            continue
        yield EncodedMessage(time, order, topic, data[start + MESSAGE_HEAD.size : end])
