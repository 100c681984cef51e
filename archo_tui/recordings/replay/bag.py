"""A reader of ROS bags of any tool: their messages in the order of time.

Memory and time are bounded whatever a file contains; what cannot be read is left out and told.

Messages are decoded by the installed class of their type, if its fields are those of the file.
mcap-ros2-support decodes without a class. It does not serve here: it refuses names such as
`MoveToShelf_FeedbackMessage`, so the feedback of every goal; it has no `wstring`, and reads a
`char` above 127 as negative.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from operator import itemgetter
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from archo_tui.base.errors import ArchoError, in_one_line
from archo_tui.base.regular_files import open_regular
from archo_tui.base.safe_text import harmless
from archo_tui.recordings import store
from archo_tui.recordings.replay import mcap_file
from archo_tui.recordings.replay.mcap_file import (
    MAGIC,
    Budget,
    BudgetExceeded,
    Index,
    Part,
    Unreadable,
)
from archo_tui.robot.messages.definitions import definition
from archo_tui.robot.messages.types import EMPTY, load_class
from archo_tui.ros.names import InterfaceType, base_name, package_of, parse_type

_FEEDBACK = "_FeedbackMessage"
_SEPARATOR = re.compile(r"^=+[ \t]*$", re.MULTILINE)  # Between the messages of a definition.
_FIELD = re.compile(r"([\w/]+)(?:<=\d+)?(?:(\[)(<=)?(\d*)\])?[ \t]+(\w+)\b(?![ \t]*=)")
_ALIASES = {"char": "uint8", "Header": "std_msgs/Header"}
_PRIMITIVES = {"bool", "byte", "string", "wstring", "float32", "float64"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}

_Field = tuple[str, str, str]  # Element type, array form, name.
_Layout = dict[str, list[_Field]]  # The fields of each message by `package/Name`.


@lru_cache(200)
def _find_class(type_name: str, encoding: str, definition_text: bytes) -> Any:
    """Return the class of `package/kind/Name`, or raise Unreadable."""
    parts = parse_type(type_name)
    made = None if parts is None else _load_class(parts)
    if parts is None or made is None:
        raise Unreadable(f"{type_name} is not installed here")
    root = f"{parts.package}/{parts.name}"
    theirs = _parse_layout(definition_text.decode(errors="replace"), root)
    ours = _parse_layout(definition(made), root)  # It has the messages within it, and no others.
    if encoding == "ros2msg" and any(theirs.get(name) != ours[name] for name in ours):
        raise Unreadable(f"{type_name} has other fields here than in the file")
    return made


def _load_class(parts: InterfaceType) -> Any:
    made = load_class(str(parts))
    if made is None and parts.kind == "action" and parts.name.endswith(_FEEDBACK):
        action = load_class(str(parts).removesuffix(_FEEDBACK))
        made = getattr(getattr(action, "Impl", None), "FeedbackMessage", None)
    return made if hasattr(made, "get_fields_and_field_types") else None


def _parse_layout(text: str, root: str) -> _Layout:
    """Return the fields of each message by `package/Name`; bounds and defaults take no bytes."""
    found: _Layout = {}
    for number, part in enumerate(_SEPARATOR.split(text)):
        name, body = root, part
        if number:
            head, _, body = part.lstrip().partition("\n")
            name = _full_name(head.removeprefix("MSG:").strip(), root)
        found.setdefault(name, _parse_fields(body, name))
    return found


def _parse_fields(text: str, owner: str) -> list[_Field]:
    found = []
    for line in text.splitlines():
        field = _FIELD.match(line.strip())
        if field and field[5] != EMPTY:
            kind = _ALIASES.get(field[1], field[1])
            if kind not in _PRIMITIVES:
                kind = _full_name(kind, owner)
            size = "" if field[3] else field[4] or ""
            found.append((kind, f"[{size}]" if field[2] else "", field[5]))
    return found


def _full_name(name: str, owner: str) -> str:
    """Return a type as `package/Name`; one without a package is of that of its `owner`."""
    package = package_of(name if "/" in name else owner)
    return f"{package}/{base_name(name)}"


MAX_MESSAGES, MAX_BYTES = 500_000, 100_000_000  # Of one reading, encoded.
_MAX_MESSAGE_BYTES = 4_000_000  # Of a message; decoding more takes seconds.
_MAX_FAULTS = 100  # Lines.
_MAX_REASON = 200  # Characters.
_SUFFIX = ".mcap"
_SQLITE = "an SQLite bag: `ros2 bag convert` makes an MCAP of it"
_ZSTD = "compressed as a whole: unpack it (zstd -d FILE) and give what comes out"
_ROS1 = "a ROS 1 bag: `rosbags-convert` makes a ROS 2 bag of it"
# Advice by the suffix of a file.
_OTHERS = {".db3": _SQLITE, ".mcap.zstd": _ZSTD, ".db3.zstd": _ZSTD, ".bag": _ROS1}


class Faults:
    """A bounded number of lines about what could not be read, each once."""

    def __init__(self) -> None:
        self._lines: dict[str, str] = {}  # By what they are about.

    def add(self, text: str, about: str = "") -> None:
        """Add a line, unless there is one, or one about the same."""
        about = about or text
        if len(self._lines) < _MAX_FAULTS:
            self._lines.setdefault(about, harmless(text))
        elif about not in self._lines:
            self._lines[""] = "and more"

    def add_message(self, topic: str, reason: str) -> None:
        """Add that messages of a topic cannot be read, by the first reason for that."""
        self.add(f"{topic}: some messages cannot be read: {reason[:_MAX_REASON]}", topic)

    def lines(self) -> list[str]:
        return [*self._lines.values()]


class BagMessage(NamedTuple):
    """A decoded message, with the Unix time of its recording."""

    time: float
    topic: str
    message: Any


Encoded = tuple[int, str, bytes]  # Log time in ns since the epoch, topic, CDR.


class _FilePart(NamedTuple):
    part: Part
    path: Path
    topics: Mapping[int, str]  # Those that can be decoded, by channel.


class BagFile:
    """A ROS bag: a folder with .mcap files, or one such file. `start` and `end` are Unix times."""

    def __init__(self, path: Path) -> None:
        """Index the files; raise ArchoError if the path is no bag, or none of them can be read."""
        self.path, self.count, self.robot = path, 0, ""
        self.types: dict[str, str] = {}
        self._classes: dict[str, Any] = {}  # By topic, as `types`.
        self._faults = Faults()
        self._parts: list[_FilePart] = []
        first, last, refused, files = 2**64, 0, list[ArchoError](), _mcap_files(path)
        budget = Budget()
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
        for name in store.missing_parts(path):
            self._faults.add(f"{name} is missing: metadata.yaml names it as a part of this bag")
        self.start, self.end = (first / 1e9, last / 1e9) if self.count else (0.0, 0.0)
        self._parts.sort(key=lambda file_part: file_part.part.start)

    @property
    def faults(self) -> list[str]:
        """A line about each thing that could not be read so far."""
        return self._faults.lines()

    def messages(
        self,
        begin: float,
        end: float,
        wanted: Container[str],
        on_cut: Callable[[], None] = lambda: None,
    ) -> Iterator[BagMessage]:
        """Yield the decoded messages between two Unix times; `on_cut` says that some lack."""
        found, is_cut = self._read(begin, end, wanted, self._faults)
        if is_cut:
            on_cut()
        found.reverse()
        while found:
            time, topic, data = found.pop()  # Frees its bytes once it is decoded.
            try:
                yield BagMessage(time / 1e9, topic, self.decode(topic, data))
            except ArchoError as error:
                self._faults.add_message(topic, str(error))

    def decode(self, topic: str, data: bytes) -> Any:
        """Return a message of a topic; ArchoError if it cannot be decoded."""
        from rclpy.serialization import deserialize_message

        try:
            return deserialize_message(data, self._classes[topic])
        except Exception as error:  # Of many kinds: message classes check their values, too.
            raise ArchoError(in_one_line(error)) from None

    def encoded_messages(
        self, begin: float, end: float, topic: str
    ) -> tuple[list[Encoded], bool, list[str]]:
        """Return messages of a topic, whether there were too many, and what is left out."""
        faults = Faults()
        return *self._read(begin, end, (topic,), faults), faults.lines()

    def _read(
        self, begin: float, end: float, wanted: Container[str], faults: Faults
    ) -> tuple[list[Encoded], bool]:
        found, left, budget = list[Encoded](), MAX_BYTES, Budget()
        channels: dict[Path, dict[int, str]] = {}
        is_cut = False
        for part, path, topics in self._parts:
            if part.start / 1e9 > end:
                break
            if path not in channels:
                channels[path] = {n: topic for n, topic in topics.items() if topic in wanted}
            named = channels[path]
            if part.end / 1e9 < begin or not named:
                continue
            try:
                with _opened(path) as file:
                    for channel, time, data in mcap_file.messages_of(file, part, named, budget):
                        if len(data) > _MAX_MESSAGE_BYTES:
                            size = f"larger than {_MAX_MESSAGE_BYTES // 10**6} MB"
                            faults.add_message(named[channel], size)
                        elif begin <= time / 1e9 <= end:
                            left -= len(data)
                            if left < 0 or len(found) == MAX_MESSAGES:
                                limit = f"{MAX_MESSAGES:,} messages or {MAX_BYTES // 10**6} MB"
                                raise BudgetExceeded(f"more than {limit} at a time")
                            found.append((time, named[channel], data))
            except BudgetExceeded as error:
                faults.add(f"{error}: the rest is left out")
                is_cut = True
                break
            except Unreadable as error:
                if not part.is_cut:  # The index has told that already.
                    faults.add(f"{path.name}: the chunk at {part.offset} bytes: {error}")
            except ArchoError as error:
                faults.add(str(error))
            except OSError as error:
                faults.add(f"{path.name}: {error.strerror}")
        found.sort(key=itemgetter(0))  # Else in the order of the file.
        return found, is_cut

    def _index_file(self, path: Path, budget: Budget) -> Index:
        def fault(text: str) -> None:
            self._faults.add(f"{path.name}: {text}")

        with _opened(path) as file:
            index = mcap_file.read_index(file, os.fstat(file.fileno()).st_size, budget, fault)
        topics = self._readable_topics(path, index)
        self._parts += [_FilePart(part, path, topics) for part in index.parts]
        return index

    def _readable_topics(self, path: Path, index: Index) -> dict[int, str]:
        """Return the topics that can be decoded, by channel; others become faults.

        Of the former, type and class are noted by topic.
        """
        encodings = {channel.message_encoding for channel in index.channels.values()}
        if encodings and index.profile != "ros2" and "cdr" not in encodings:
            if index.profile == "ros1":
                raise _error(path, _ROS1)
            encoding = min(encodings) or "nothing known"
            reason = f"not of ROS 2: its messages are encoded as {encoding}"
            raise _error(path, f"{reason}, those of a ROS 2 bag as cdr")
        found = {}
        for number, channel in index.channels.items():
            topic, encoding = channel.topic, channel.message_encoding
            schema = index.schemas.get(channel.schema_id)
            try:
                if encoding != "cdr":
                    raise Unreadable(f"encoded as {encoding or 'nothing known'}, not cdr")
                if schema is None:
                    raise Unreadable("its type is not named")
                kind = _find_class(schema.name, schema.encoding, schema.data)
                if self.types.setdefault(topic, schema.name) != schema.name:
                    raise Unreadable(f"{schema.name}, where {self.types[topic]} came before")
                if schema.encoding != "ros2msg":
                    read_as = f"its definition is not compared: read as {schema.name} here"
                    self._faults.add(f"{topic}: {read_as}")
                found[number], self._classes[topic] = topic, kind
            except Unreadable as error:
                self._faults.add(f"{topic}: left out: {error}")
        return found


def _mcap_files(path: Path) -> list[Path]:
    try:
        if not path.is_dir():
            return [path]
        names = sorted(os.listdir(path))
    except OSError as error:
        raise _error(path, _reason(error)) from None
    found = [path / name for name in names if name.endswith(_SUFFIX) and name[0] != "."]
    if found:
        return found
    raise _error(path, _advice(*names) or "no .mcap file is in it: give the folder of a bag")


def _advice(*names: str) -> str:
    """Return how to read a file of another format; "" if none of the names is one's."""
    found = (advice for suffix, advice in _OTHERS.items() if any(n.endswith(suffix) for n in names))
    return next(found, "")


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    """Open an MCAP file, behind its first bytes, or raise ArchoError with advice."""
    try:
        descriptor = open_regular(path, os.O_RDONLY)
    except FileNotFoundError:
        raise _error(path, "was not found: give the folder of a bag, or a .mcap file") from None
    except (OSError, ValueError) as error:
        raise _error(path, _reason(error)) from None
    with open(descriptor, "rb") as file:
        try:
            begin = file.read(len(MAGIC))
        except OSError as error:
            raise _error(path, _reason(error)) from None
        if not begin:
            raise _error(path, "it is empty: nothing was recorded in it")
        if begin != MAGIC:
            none = "not a bag: give a .mcap file, or a folder with some"
            raise _error(path, _advice(path.name) or none)
        yield file


def _reason(error: OSError | ValueError) -> str:
    return getattr(error, "strerror", None) or str(error)


def _error(path: Path, why: str) -> ArchoError:
    return ArchoError(f"{path}: {why}")
