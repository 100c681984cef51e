"""The fields of a topic's messages as rows, with ranges and a minute of values. Pure.

All numbers are read from each message, but the rows are made for each picture only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from itertools import islice
from operator import attrgetter
from typing import Any, NamedTuple

from archo_tui.errors import ArchoError, in_one_line
from archo_tui.robot.messages.definitions import value_names
from archo_tui.robot.messages.text import as_list, find_field, primitive, shortened, summarize
from archo_tui.robot.messages.types import (
    DURATION,
    INTEGERS,
    NESTED,
    TIME,
    element_of,
    kinds,
    name_of,
    ros2msg_type,
)
from archo_tui.robot.state.topic import (
    SHOWN_ELEMENTS,
    Curve,
    FieldKind,
    FieldView,
    TopicRequest,
    TopicView,
)
from archo_tui.robot.topics.series import Series

MAX_FIELDS = 2_000  # Rows of one message.
SPAN = 60.0  # Seconds of values.
PER_SECOND = 10  # Least and greatest of a field are kept for each tenth of a second.
_NUMBERS = {*INTEGERS, "float", "double", "boolean"}
_Convert = Callable[[Any], float] | None  # None where a value is a number already.


class _FieldType(NamedTuple):
    name: str
    kind: str  # As rosidl writes it.
    element: str | None  # The type of an array's elements.
    names: Mapping[int, str]  # The names that its type gives to its values.

    @property
    def is_message(self) -> bool:
        return self.element is None and NESTED.fullmatch(self.kind) is not None


def _field_types(message: Any) -> tuple[_FieldType, ...]:
    message_class: Any = type(message)
    return _types_of(message_class)


@lru_cache(256)
def _types_of(message_class: Any) -> tuple[_FieldType, ...]:
    names = value_names(name_of(message_class))
    return tuple(
        _FieldType(name, kind, element_of(kind), names.get(name, {}))
        for name, kind in kinds(message_class).items()
    )


def field_rows(message: Any, open_arrays: Mapping[str, int]) -> tuple[list[FieldView], bool]:
    """Return the rows of a message, at most `MAX_FIELDS`, and True if it has more.

    `open_arrays` has, by path, the first element that is shown. A large message takes long, and
    interface files may be read: call this on no thread that others wait for.
    """
    found = list(islice(_fields(message, "", open_arrays), MAX_FIELDS + 1))
    return found[:MAX_FIELDS], len(found) > MAX_FIELDS


def _fields(message: Any, before: str, open_arrays: Mapping[str, int]) -> Iterator[FieldView]:
    for field in _field_types(message):
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


class _MessageNumbers:
    """A reader of all numbers in messages of one class, outside of arrays, at once.

    That is far cheaper than to make its rows. Bools and Durations count as numbers.
    """

    def __init__(self, message: Any) -> None:
        found = dict(_numbers(message, ""))
        self.paths = tuple(found)[:MAX_FIELDS]
        self._get = attrgetter(*self.paths) if self.paths else None
        # Most values are numbers already.
        self._convert = [
            (place, convert) for place, path in enumerate(self.paths) if (convert := found[path])
        ]

    def read(self, message: Any) -> tuple[Any, ...]:
        """Return the numbers of a message of the same class, in the order of `paths`."""
        if self._get is None:
            return ()
        read = self._get(message)
        values: tuple[Any, ...] = (read,) if len(self.paths) == 1 else read
        if self._convert:
            changed = list(values)
            for place, convert in self._convert:
                changed[place] = convert(changed[place])
            values = tuple(changed)
        return values


def _element_numbers(message: Any, open_arrays: Mapping[str, int]) -> Iterator[tuple[str, Any]]:
    """Yield path and value of the numbers in those elements of open arrays that are shown."""
    for path, begin in open_arrays.items():
        try:
            array = find_field(message, path)
        except ArchoError:  # It was an element of an array that has become shorter.
            continue
        element, value = element_of(array.type) or "", array.default
        shown = shown_elements(begin, len(value))
        convert = _converter(element)
        for index, item in zip(shown, as_list(value[shown.start : shown.stop]), strict=True):
            where = f"{path}[{index}]"
            if element in _NUMBERS or element == DURATION:
                yield where, convert(item) if convert else item
            elif element != TIME and NESTED.fullmatch(element):
                for inner, convert_inner in _numbers(item, ""):
                    found = attrgetter(inner)(item)
                    yield f"{where}.{inner}", convert_inner(found) if convert_inner else found


def _numbers(message: Any, before: str) -> Iterator[tuple[str, _Convert]]:
    """Yield the path of each number outside of arrays, and what converts its value."""
    for field in _field_types(message):
        path = f"{before}{field.name}"
        if field.kind in _NUMBERS or field.kind == DURATION:
            yield path, _converter(field.kind)
        elif field.is_message and field.kind != TIME:
            yield from _numbers(getattr(message, field.name), f"{path}.")


def _converter(kind: str) -> _Convert:
    if kind == "octet":
        return lambda value: int(value[0])
    return _seconds if kind == DURATION else None


class TopicFields:
    """The rows, ranges and curves of a topic's fields since the topic was opened.

    `is_cut` is True if the message of the last `rows` has more fields than are returned.
    """

    def __init__(self, units: Mapping[str, str]) -> None:
        self._units = units  # Of the robot file, by path.
        self._histories: dict[str, Series] = {}
        self._numbers: _MessageNumbers | None = None  # Of the class of the last message.
        self._of_numbers: list[Series] = []  # In the order of their paths.
        self.message: Any = None  # The last one.
        self._read: tuple[Any, Mapping[str, int]] = None, {}  # What the rows were made of.
        self._rows: list[FieldView] = []
        self._shown: tuple[FieldView, ...] = ()  # The rows that were returned last.
        self.is_cut = False

    def add(self, time: float, message: Any, open_arrays: Mapping[str, int]) -> None:
        """Make a message the last one, and add its numbers to ranges and curves; NaN is left out.

        `time` is on the clock of `rows`. A hostile message may raise anything.
        """
        numbers = self._numbers
        if numbers is None or type(message) is not type(self.message):
            numbers = self._numbers = _MessageNumbers(message)
            self._of_numbers = [self._history(path) for path in numbers.paths]
        self.message = message
        tenth = math.floor(time * PER_SECOND)
        for history, value in zip(self._of_numbers, numbers.read(message), strict=True):
            if math.isfinite(value):
                history.add(tenth, value)
        for path, value in _element_numbers(message, open_arrays):
            if math.isfinite(value):
                self._history(path).add(tenth, value)

    def _history(self, path: str) -> Series:
        return self._histories.setdefault(path, Series(PER_SECOND, round(SPAN * PER_SECOND)))

    def rows(self, now: float, request: TopicRequest) -> tuple[FieldView, ...]:
        """Return the rows of the last message, with ranges and the visible curves; () without one.

        A row that has not changed is the same object as before.
        """
        if self.message is None:
            return ()
        read, open_arrays = self._read
        if read is not self.message or open_arrays != request.open_arrays:
            self._rows, self.is_cut = field_rows(self.message, request.open_arrays)
            self._read = self.message, request.open_arrays
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
    """Return a view of a message with the elements of other arrays; an error becomes its fault.

    Fields that the view has keep their ranges and curves.
    """
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
