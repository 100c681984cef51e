"""A reader of ROS bags from any tool, yielding their messages in the order of time.

Memory and time are bounded whatever a file contains. What cannot be read is left out and reported.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from archo_tui.errors import ArchoError
from archo_tui.replay import bag_paths
from archo_tui.replay.chunks import BudgetExceeded, ReadBudget, Unreadable
from archo_tui.replay.faults import Faults
from archo_tui.replay.installed_types import InstalledTypes
from archo_tui.replay.linear_reader import LinearReader
from archo_tui.replay.mcap_index import MAX_CHANNELS, MAX_RANGES, Index
from archo_tui.replay.message_reader import FileRange, ReadMessages, Topic, read_messages
from archo_tui.replay.summary import read_summary


class BagMessage(NamedTuple):
    """A decoded message of a bag."""

    time: float  # Unix time of its recording, in s.
    topic: str
    message: Any  # An object of the installed class.


class BagFile:
    """A ROS bag: a folder with .mcap files, or one such file.

    Attributes:
        path: The path that was given.
        count: The number of messages in the files that were accepted, decodable or not.
        robot: The text of the first robot file that is attached; "" if there is none.
        types: The type of each topic that can be decoded, as `package/kind/Name`, by full names.
        start: Unix time of the first message, in s; 0 if there is none.
        end: Unix time of the last message, in s; 0 if there is none.
    """

    def __init__(self, path: Path) -> None:
        """Index the bag's files, without keeping them open or decoding messages.

        Files and topics that cannot be read are left out and reported by `faults`.

        Raises:
            ArchoError: The path is no bag, or none of its files can be read.
        """
        self.path = path
        self.count = 0
        self.robot = ""
        self._types: dict[str, str] = {}
        self.types: Mapping[str, str] = self._types
        self._faults, self._installed = Faults(), InstalledTypes()
        self._ranges: list[FileRange] = []
        budget, files = ReadBudget(), bag_paths.mcap_files(path)
        first, last, refused = 2**64, 0, list[ArchoError]()
        for file in files:
            try:
                index = self._index_file(file, budget)
            except ArchoError as error:
                refused.append(error)
                continue
            first, last = min(first, index.start), max(last, index.end)
            self.count += index.count
            self.robot = self.robot or index.robot
        if len(refused) == len(files):
            raise refused[0]
        for refusal in refused:
            self._faults.add(str(refusal))
        self.start, self.end = (first / 1e9, last / 1e9) if self.count else (0.0, 0.0)
        self._ranges.sort(key=lambda file_range: file_range.messages.start)

    @property
    def faults(self) -> list[str]:
        """Return the faults found so far: of files and topics, then a line for a topic's messages.

        Of each of these two kinds at most 100 lines are kept.
        """
        return self._faults.lines()

    def messages(
        self,
        begin: float,
        end: float,
        wanted: Container[str],
        on_cut: Callable[[], None] = lambda: None,
    ) -> Iterator[BagMessage]:
        """Yield decoded messages in the order of time.

        All of them are loaded before the first is yielded: at most 500,000 or 100 MB; the rest is
        left out. Whatever is left out is reported by `faults`.

        Args:
            begin: Unix time of the first message, in s; itself included.
            end: Unix time of the last message, in s; itself included.
            wanted: The topics, by full names.
            on_cut: Called before the first message if some before `end` are left out at the end.
        """
        from rclpy.serialization import deserialize_message

        found, is_cut = read_messages(self._ranges, begin, end, wanted, self._faults)
        if is_cut:
            on_cut()
        found.reverse()
        while found:
            encoded = found.pop()  # Frees its bytes once it is decoded.
            try:
                message = deserialize_message(encoded.data, encoded.topic.message_class)
            except Exception as error:  # Of many kinds: message classes check their values, too.
                self._faults.add_message(encoded.topic.name, encoded.order, str(error))
                continue
            yield BagMessage(encoded.time / 1e9, encoded.topic.name, message)

    def encoded_messages(self, begin: float, end: float, topic: str) -> tuple[ReadMessages, Faults]:
        """Return the messages of a topic as bytes, in the order of time, and what was left out.

        At most 500,000 messages or 100 MB are returned. `faults` does not report what this call
        left out.

        Args:
            begin: Unix time of the first message, in s; itself included.
            end: Unix time of the last message, in s; itself included.
            topic: The full name of the topic.
        """
        faults = Faults()
        return read_messages(self._ranges, begin, end, (topic,), faults), faults

    def _index_file(self, path: Path, budget: ReadBudget) -> Index:
        """Index a file, and add its message ranges and topics to those of the bag.

        What is found before a read error or the end of the budget counts; the rest is a fault.

        Raises:
            ArchoError: The file cannot be opened, is no MCAP file, or is not of ROS 2.
        """
        fault = partial(self._add_fault, path)
        index = Index(fault)
        with bag_paths.opened(path) as file:
            size = os.fstat(file.fileno()).st_size
            try:
                if not read_summary(file, size, index, budget):
                    index = Index(fault)
                    LinearReader(file, size, index, budget).run()
            except BudgetExceeded as error:
                fault(f"{error}: the rest is left out")
            except OSError as error:
                fault(f"{error.strerror}: the rest is left out")
        topics = self._readable_topics(path, index)
        free = MAX_RANGES - len(self._ranges)
        if len(index.ranges) > free:
            fault(f"more than {MAX_RANGES:,} chunks in all: the rest is left out")
        self._ranges += [FileRange(messages, path, topics) for messages in index.ranges[:free]]
        return index

    def _readable_topics(self, path: Path, index: Index) -> dict[int, Topic]:
        """Return the topics of a file that can be decoded, by channel, and note their types.

        The others are reported as faults, and so are topics whose definition cannot be compared.

        Raises:
            ArchoError: The file's profile is not `ros2`, and no channel is encoded as CDR.
        """
        encodings = {channel.encoding for channel in index.channels.values()}
        if encodings and index.profile != "ros2" and "cdr" not in encodings:
            raise bag_paths.foreign_system_error(path, index.profile, min(encodings))
        found = {}
        for channel, (topic, encoding, schema_id) in index.channels.items():
            schema = index.schemas.get(schema_id)
            try:
                if encoding != "cdr":
                    raise Unreadable(f"encoded as {encoding or 'nothing known'}, not cdr")
                if schema is None:
                    raise Unreadable("its type is not named")
                kind = self._installed.find_class(schema.name, schema.encoding, schema.text)
                if topic not in self._types and len(self._types) == MAX_CHANNELS:
                    raise Unreadable(f"more than {MAX_CHANNELS:,} topics")
                if self._types.setdefault(topic, schema.name) != schema.name:
                    raise Unreadable(f"{schema.name}, where {self._types[topic]} came before")
                if schema.encoding != "ros2msg":
                    name = schema.name
                    self._faults.add(
                        f"{topic}: its definition is not compared: read as {name} here"
                    )
                found[channel] = Topic(topic, kind)
            except Unreadable as error:
                self._faults.add(f"{topic}: left out: {error}")
        return found

    def _add_fault(self, path: Path, text: str) -> None:
        self._faults.add(f"{path.name}: {text}")
