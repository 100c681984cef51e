"""A bag, as this console or any other tool has recorded it: its messages, in the order of time.

Whatever its files say, memory and time are bounded: what cannot be read is left out and said.
"""

from __future__ import annotations

import os
from collections.abc import Container, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from archo_tui.errors import ArchoError
from archo_tui.replay import bag_paths
from archo_tui.replay.chunks import TooMuch, Unreadable, Work
from archo_tui.replay.faults import Faults
from archo_tui.replay.held import Part, Topic, held
from archo_tui.replay.mcap_index import MOST_CHANNELS, MOST_PIECES, Index
from archo_tui.replay.received_types import ReceivedTypes
from archo_tui.replay.summary import read_summary
from archo_tui.replay.walk import Walk


class Said(NamedTuple):
    """One message."""

    time: float  # Unix time at which it was recorded, in s
    topic: str
    message: Any  # an object of the installed class


class BagFile:
    """One bag: a folder with .mcap files, or such a file."""

    def __init__(self, path: Path) -> None:
        """Look through it. Raises ArchoError when it is no bag, or none that can be read here."""
        self.path = path
        self.counts = 0  # messages in all, readable or not
        self.robot = ""  # the robot file that was recorded with them
        self._types: dict[str, str] = {}
        # "package/kind/Name" by topic, of those that can be read
        self.types: Mapping[str, str] = self._types
        self._faults, self._received = Faults(), ReceivedTypes()
        self._parts: list[Part] = []
        work, files = Work(), bag_paths.files(path)
        first, last, refused = 2**64, 0, list[ArchoError]()
        for file in files:
            try:
                index = self._index(file, work)
            except ArchoError as error:
                refused.append(error)
                continue
            first, last = min(first, index.start), max(last, index.end)
            self.counts += index.count
            self.robot = self.robot or index.robot
        if len(refused) == len(files):
            raise refused[0]
        for why in refused:
            self._faults.add(str(why))
        # Unix times of the first and the last message, in s
        self.start, self.end = (first / 1e9, last / 1e9) if self.counts else (0.0, 0.0)
        self._parts.sort(key=lambda part: part.piece.start)

    @property
    def faults(self) -> list[str]:
        """What cannot be read, a line each; there may be more when more was read."""
        return self._faults.lines()

    def messages(self, begin: float, end: float, wanted: Container[str]) -> Iterator[Said]:
        """Those of some topics within two Unix times, in the order of time.

        What cannot be read is left out, and a line of `faults`.
        """
        from rclpy.serialization import deserialize_message

        found = held(self._parts, begin, end, wanted, self._faults)
        found.reverse()
        while found:
            one = found.pop()  # what is decoded is held no longer
            try:
                message = deserialize_message(one.data, one.topic.kind)
            except Exception as error:  # of many kinds: a class checks its values, too
                self._faults.add_message(one.topic.name, one.place, str(error))
                continue
            yield Said(one.time / 1e9, one.topic.name, message)

    def _index(self, path: Path, work: Work) -> Index:
        """Look through one file. Raises ArchoError."""
        fault = partial(self._fault_in, path)
        index = Index(fault)
        with bag_paths.opened(path) as file:
            size = os.fstat(file.fileno()).st_size
            try:
                if not read_summary(file, size, index, work):
                    index = Index(fault)
                    Walk(file, size, index, work).run()
            except TooMuch as error:
                fault(f"{error}: the rest is left out")
            except OSError as error:
                fault(f"{error.strerror}: the rest is left out")
        topics = self._topics(path, index)
        room = MOST_PIECES - len(self._parts)
        if len(index.pieces) > room:
            fault(f"more than {MOST_PIECES:,} chunks in all: the rest is left out")
        self._parts += [Part(piece, path, topics) for piece in index.pieces[:room]]
        return index

    def _topics(self, path: Path, index: Index) -> dict[int, Topic]:
        """What can be read, by channel. Raises ArchoError for a file of another system."""
        encodings = {one.encoding for one in index.channels.values()}
        if encodings and index.profile != "ros2" and "cdr" not in encodings:
            raise bag_paths.another_system(path, index.profile, min(encodings))
        found = {}
        for number, (topic, encoding, wanted) in index.channels.items():
            schema = index.schemas.get(wanted)
            try:
                if encoding != "cdr":
                    raise Unreadable(f"encoded as {encoding or 'nothing known'}, not cdr")
                if schema is None:
                    raise Unreadable("its type is not named")
                kind = self._received.find(schema.name, schema.encoding, schema.text)
                if topic not in self._types and len(self._types) == MOST_CHANNELS:
                    raise Unreadable(f"more than {MOST_CHANNELS:,} topics")
                if self._types.setdefault(topic, schema.name) != schema.name:
                    raise Unreadable(f"{schema.name}, where {self._types[topic]} came before")
                if schema.encoding != "ros2msg":
                    name = schema.name
                    self._faults.add(
                        f"{topic}: its definition is not compared: read as {name} here"
                    )
                found[number] = Topic(topic, kind)
            except Unreadable as error:
                self._faults.add(f"{topic}: left out: {error}")
        return found

    def _fault_in(self, path: Path, said: str) -> None:
        self._faults.add(f"{path.name}: {said}")
