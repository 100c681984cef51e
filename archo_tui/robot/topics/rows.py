"""The fields of a topic's messages as rows, with ranges and a minute of values. Pure."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping
from enum import Enum, auto
from functools import lru_cache
from itertools import islice
from typing import Any, NamedTuple

from archo_tui.base.errors import in_one_line
from archo_tui.robot.messages.definitions import value_names
from archo_tui.robot.messages.text import as_list, primitive, shortened, summarize
from archo_tui.robot.messages.types import (
    DURATION,
    NESTED,
    TIME,
    element_of,
    kinds,
    name_of,
    ros2msg_type,
)
from archo_tui.robot.state.graph import TopicInfo

MAX_FIELDS = 2_000  # Rows of one message.
SPAN = 60.0  # Seconds of values.
PER_SECOND = 10  # Least and greatest of a field are kept for each tenth of a second.


Range = tuple[float, float]  # The least and the greatest value.
Curve = tuple[Range | None, ...]  # The values of the last minute, the oldest first; None: no value.


SHOWN_ELEMENTS = 20  # Of an open array.


class FieldKind(Enum):
    """The kinds of rows of a message."""

    VALUE = auto()  # A number, a text, a bool or a time.
    GROUP = auto()  # A message, whose fields follow.
    ARRAY = auto()
    MORE = auto()  # The elements of an open array that are not shown.


class FieldView(NamedTuple):
    """A row for a field of a message, or for an element of an array that is open."""

    path: str  # Its dotted path: `pose.position.x`, `ranges[3]`.
    kind: FieldKind
    type: str  # Its type as .msg files write it; of an array with its length: `float32[360]`.
    value: bool | float | str | None = None  # Its value, NaN also; None for a group.
    is_time: bool = False  # True if the value is a time of day.
    unit: str = ""  # Its unit; "" if neither its definition nor the robot file names one.
    constant: str = ""  # The name that the type gives to this value, or "".
    least: float | None = None  # The least value since the topic was opened.
    greatest: float | None = None  # The greatest value, as `least`.
    nan: int = 0  # Of an array, the number of elements that are NaN.
    first: str = ""  # Of an array of bytes, the first ones in hexadecimal.
    is_open: bool = False  # True for an array whose elements follow.
    curve: Curve = ()  # Its values of the last minute; () if they were not asked for.


class TopicView(NamedTuple):
    """A topic at one moment."""

    topic: str
    type: str = ""  # The type of its messages; "" while none is known.
    received: int = 0  # The number of messages that came since the topic was opened.
    rate: float | None = None  # The messages in a second; None before three intervals.
    bytes_per_second: float | None = None  # The bytes of these messages in a second.
    age: float | None = None  # Seconds since the last message.
    fields: tuple[FieldView, ...] = ()  # The rows for the fields of the last message, in its order.
    is_cut: bool = False  # True if the message has more fields than are shown.
    # The values of the last minute by path, for those that were asked for.
    plots: Mapping[str, Curve] = {}
    ends: TopicInfo | None = None  # Its publishers and subscriptions; None if they are not known.
    fault: str = ""  # Why nothing is shown, or why not the last message; "" if nothing is wrong.
    # The arrays whose elements are among the fields: by path, the first element.
    open_arrays: Mapping[str, int] = {}
    # Takes this view and other `open_arrays`, and returns the view with the elements of these, from
    # the same message.
    with_elements: Callable[[TopicView, Mapping[str, int]], TopicView] | None = None


class TopicRequest(NamedTuple):
    """The parts of a view that a screen needs."""

    # The arrays whose elements are shown: by path, the index of the first one shown.
    open_arrays: Mapping[str, int] = {}
    # The paths of the fields whose curve is shown beside them.
    visible: frozenset[str] = frozenset()
    curve_columns: int = 0  # The number of columns of such a curve.
    plotted: tuple[str, ...] = ()  # The paths of the fields that are plotted.
    plot_columns: int = 0  # The number of columns of a plot.


class _FieldType(NamedTuple):
    name: str
    kind: str  # As rosidl writes it.
    element: str | None  # The type of an array's elements.
    names: Mapping[int, str]  # The names that its type gives to its values.

    @property
    def is_message(self) -> bool:
        return self.element is None and NESTED.fullmatch(self.kind) is not None


@lru_cache(256)
def _types_of(message_class: Any) -> tuple[_FieldType, ...]:
    names = value_names(name_of(message_class))
    return tuple(
        _FieldType(name, kind, element_of(kind), names.get(name, {}))
        for name, kind in kinds(message_class).items()
    )


def field_rows(message: Any, open_arrays: Mapping[str, int]) -> tuple[list[FieldView], bool]:
    """Return the rows of a message, at most `MAX_FIELDS`, and True if it has more."""
    found = list(islice(_fields(message, "", open_arrays), MAX_FIELDS + 1))
    return found[:MAX_FIELDS], len(found) > MAX_FIELDS


def _fields(message: Any, before: str, open_arrays: Mapping[str, int]) -> Iterator[FieldView]:
    message_class: Any = type(message)
    for field in _types_of(message_class):
        yield from _row(f"{before}{field.name}", field, getattr(message, field.name), open_arrays)


def _row(
    path: str, field: _FieldType, value: Any, open_arrays: Mapping[str, int]
) -> Iterator[FieldView]:
    """Yield the row of a field or element, then those of the fields and elements inside of it."""
    kind = field.kind
    if field.element is not None:
        yield from _array(path, field, value, open_arrays)
    elif kind in (TIME, DURATION):
        is_time = kind == TIME
        unit = "" if is_time else "s"
        yield FieldView(path, FieldKind.VALUE, kind, _seconds(value), is_time=is_time, unit=unit)
    elif field.is_message:
        yield FieldView(path, FieldKind.GROUP, kind)
        yield from _fields(value, f"{path}.", open_arrays)
    else:
        shown = _shown(value, kind)
        constant = field.names.get(shown, "") if type(shown) is int else ""
        yield FieldView(path, FieldKind.VALUE, ros2msg_type(kind), shown, constant=constant)


def _array(
    path: str, field: _FieldType, value: Any, open_arrays: Mapping[str, int]
) -> Iterator[FieldView]:
    """Yield the row of an array, and, if it is open, those of some elements, and a row for more."""
    element, begin = field.element or "", open_arrays.get(path)
    summary = summarize(value, element)
    least, greatest = (
        None if end is None else _shown(end, element) for end in (summary.least, summary.greatest)
    )
    yield FieldView(
        path,
        FieldKind.ARRAY,
        summary.type,
        summary.length,
        least=least,  # type: ignore[arg-type]  # numbers stay numbers
        greatest=greatest,  # type: ignore[arg-type]
        nan=summary.nan,
        first=summary.first,
        is_open=begin is not None,
    )
    if begin is None:
        return
    shown = shown_elements(begin, summary.length)
    of = field._replace(kind=element, element=element_of(element))
    for index, item in zip(shown, as_list(value[shown.start : shown.stop]), strict=True):
        yield from _row(f"{path}[{index}]", of, item, open_arrays)
    if len(shown) < summary.length:
        yield FieldView(f"{path}[]", FieldKind.MORE, "", summary.length)


def shown_elements(begin: int, length: int) -> range:
    """Return the elements that an open array shows from `begin`, moved so that the end is full."""
    begin = max(min(begin, length - SHOWN_ELEMENTS), 0)
    return range(begin, min(begin + SHOWN_ELEMENTS, length))


def _seconds(value: Any) -> float:
    return float(value.sec + value.nanosec / 1e9)


def _shown(value: Any, kind: str) -> bool | float | str:
    shown: bool | float | str = primitive(value, kind)
    return shortened(shown) if isinstance(shown, str) else shown


class TopicFields:
    """The rows, ranges and curves of a topic's fields since the topic was opened."""

    def __init__(self, units: Mapping[str, str]) -> None:
        self._units = units  # Of the robot file, by path.
        self._histories: dict[str, Series] = {}
        self.message: Any = None  # The last one.
        self._open_arrays: Mapping[str, int] = {}  # With which its rows were made.
        self._rows: list[FieldView] = []
        self._shown: tuple[FieldView, ...] = ()  # The rows that were returned last.
        self.is_cut = False

    def add(self, time: float, message: Any, open_arrays: Mapping[str, int]) -> None:
        """Make a message the last one, and add its finite numbers to ranges and curves."""
        self._read(message, open_arrays)
        part = math.floor(time * PER_SECOND)
        for row in self._rows:
            if row.kind is not FieldKind.VALUE or row.is_time or isinstance(row.value, str):
                continue
            if row.value is not None and math.isfinite(row.value):
                self._history(row.path).add(part, row.value)

    def _read(self, message: Any, open_arrays: Mapping[str, int]) -> None:
        self._rows, self.is_cut = field_rows(message, open_arrays)
        self.message, self._open_arrays = message, open_arrays

    def _history(self, path: str) -> Series:
        return self._histories.setdefault(path, Series(PER_SECOND, round(SPAN * PER_SECOND)))

    def rows(self, now: float, request: TopicRequest) -> tuple[FieldView, ...]:
        """Return the rows of the last message; one that is unchanged is the same object."""
        if self.message is None:
            return ()
        if self._open_arrays != request.open_arrays:
            self._read(self.message, request.open_arrays)
        before = self._shown
        rows = [self._complete(row, now, request) for row in self._rows]
        for place, (old, new) in enumerate(zip(before, rows, strict=False)):
            if old == new:
                rows[place] = old
        self._shown = tuple(rows)
        return self._shown

    def plots(self, now: float, request: TopicRequest) -> dict[str, Curve]:
        """Return the curves of the plotted fields that have numbers, by path."""
        return {
            path: self._histories[path].curve(now, SPAN, request.plot_columns)
            for path in request.plotted
            if path in self._histories and request.plot_columns
        }

    def _complete(self, row: FieldView, now: float, request: TopicRequest) -> FieldView:
        unit, history = self._units.get(row.path, row.unit), self._histories.get(row.path)
        if history is None or history.is_empty:
            return row._replace(unit=unit) if unit != row.unit else row
        is_seen = row.path in request.visible and request.curve_columns
        has_range = not isinstance(row.value, bool)
        return row._replace(
            unit=unit,
            least=history.least if has_range else None,
            greatest=history.greatest if has_range else None,
            curve=history.curve(now, SPAN, request.curve_columns) if is_seen else (),
        )


def with_elements(message: Any, view: TopicView, open_arrays: Mapping[str, int]) -> TopicView:
    """Return a view of a message with the elements of other arrays; an error becomes its fault."""
    try:
        rows, is_cut = field_rows(message, open_arrays)
    except Exception as error:  # A hostile message may raise anything.
        return view._replace(fault=f"not shown: {in_one_line(error)}", open_arrays=open_arrays)
    known = {row.path: row for row in view.fields}
    fields = [
        known[row.path]._replace(is_open=row.is_open)
        if row.path in known and row.kind is not FieldKind.MORE
        else row
        for row in rows
    ]
    return view._replace(fields=tuple(fields), is_cut=is_cut, open_arrays=open_arrays)


# The values of one number over time.

# Where columns are shorter than a second, a value fills those of so many seconds, so that a topic
# of 1 Hz has no gaps, though a message comes late.
_HOLDS = 1.5
_SLACK = 100  # Parts beyond those that are kept, so that not every new one moves all others.


class Series:
    """The last values of one number, and their range since the first one."""

    def __init__(self, per_second: int, kept: int) -> None:
        """Keep so many parts of a second, the newest; `per_second` of them are a second."""
        self.least, self.greatest = math.inf, -math.inf
        self._per_second, self._kept = per_second, kept
        self._parts = array("q")  # Their numbers, counted from the time 0.0.
        self._least, self._greatest = array("d"), array("d")

    @property
    def is_empty(self) -> bool:
        """True before the first value."""
        return not self._parts

    def add(self, part: int, value: float) -> None:
        """Add a finite value at a part of a second, by its number; earlier ones do not follow."""
        # It is called thousands of times a second: `min` and `max` would take twice as long.
        if value < self.least:
            self.least = value
        if value > self.greatest:
            self.greatest = value
        if self._parts and self._parts[-1] == part:
            if value < self._least[-1]:
                self._least[-1] = value
            if value > self._greatest[-1]:
                self._greatest[-1] = value
            return
        self._least.append(value)
        self._greatest.append(value)
        self._parts.append(part)  # Last: a replay is drawn while another thread reads it.
        if len(self._parts) > self._kept + _SLACK:
            for of in (self._parts, self._least, self._greatest):
                del of[: -self._kept]

    def curve(self, now: float, span: float, columns: int) -> tuple[Range | None, ...]:
        """Return the last `span` seconds in columns, each with the range of its values, or None."""
        width = span / columns
        oldest = math.floor(now / width) - columns + 1
        found: list[Range | None] = [None] * columns
        holds = _HOLDS if width < 1.0 else 0.0
        begin = bisect_left(self._parts, math.floor((oldest * width - holds) * self._per_second))
        end = bisect_right(self._parts, math.floor(now * self._per_second))
        times = [part / self._per_second for part in self._parts[begin:end]]
        places = [max(math.floor(time / width) - oldest, -1) for time in times]
        for number, (time, place) in enumerate(zip(times, places, strict=True)):
            low, high = self._least[begin + number], self._greatest[begin + number]
            if 0 <= place < columns:
                both = found[place] or (low, high)
                found[place] = min(both[0], low), max(both[1], high)
            until = math.floor((time + holds) / width) - oldest + 1
            if number + 1 < len(places):
                until = min(until, places[number + 1])
            for held in range(max(place + 1, 0), min(until, columns)):
                found[held] = low, high
        return tuple(found)
