"""The fields of a message as rows: values, nested messages, and arrays by their summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import islice
from typing import Any, NamedTuple

from archo_tui.robot.array_summary import as_list, summarize
from archo_tui.robot.definitions import ros2msg_type
from archo_tui.robot.field_notes import FieldNotes, notes_of
from archo_tui.robot.fields import NESTED, element_of
from archo_tui.robot.message_classes import EMPTY, name_of
from archo_tui.robot.message_text import primitive, shortened
from archo_tui.robot.state import SHOWN_ELEMENTS, FieldKind, FieldView

MAX_FIELDS = 2_000  # Rows of one message.
TIME, DURATION = "builtin_interfaces/Time", "builtin_interfaces/Duration"


class FieldType(NamedTuple):
    """A field of a message, as its type describes it.

    Attributes:
        name: The name of the field.
        kind: The type of the field, as rosidl writes it.
        type: The type of a primitive field, as .msg files write it; else the same as `kind`.
        element: The type of an array's elements, as rosidl writes it; None if it is no array.
        is_message: True for a nested message, but not for an array of messages.
        notes: The notes on the type that has the field.
    """

    name: str
    kind: str
    type: str
    element: str | None
    is_message: bool
    notes: FieldNotes


def field_types(message: Any) -> tuple[FieldType, ...]:
    """Return the fields of a message's class, in order.

    The first time, the interface file of the class is read.
    """
    message_class: Any = type(message)
    return _field_types(message_class)


@lru_cache(256)
def _field_types(message_class: Any) -> tuple[FieldType, ...]:
    notes = notes_of(name_of(message_class))
    kinds = message_class.get_fields_and_field_types()
    return tuple(_field_type(name, kind, notes) for name, kind in kinds.items() if name != EMPTY)


def _field_type(name: str, kind: str, notes: FieldNotes) -> FieldType:
    element = element_of(kind)
    is_message = element is None and NESTED.fullmatch(kind) is not None
    shown = kind if element is not None or is_message else ros2msg_type(kind)
    return FieldType(name, kind, shown, element, is_message, notes)


def field_rows(message: Any, open_arrays: Mapping[str, int]) -> tuple[list[FieldView], bool]:
    """Return the rows of a message, at most `MAX_FIELDS`, and True if it has more.

    A large message takes long, and the interface files of types that are new are read: call this on
    no thread that others wait for.

    Args:
        message: The message.
        open_arrays: The arrays some of whose elements have rows, too: the number of the first such
            element, by the path of the array.
    """
    found = list(islice(_fields(message, "", open_arrays), MAX_FIELDS + 1))
    return found[:MAX_FIELDS], len(found) > MAX_FIELDS


def _fields(message: Any, before: str, open_arrays: Mapping[str, int]) -> Iterator[FieldView]:
    """Yield the rows of a message's fields, nested ones included.

    Args:
        message: The message.
        before: The path of the message with a dot behind it, or "".
        open_arrays: As for `field_rows`.
    """
    for field in field_types(message):
        yield from _row(f"{before}{field.name}", field, getattr(message, field.name), open_arrays)


def _row(
    path: str, field: FieldType, value: Any, open_arrays: Mapping[str, int]
) -> Iterator[FieldView]:
    """Yield the row of a field or element, then those of the fields and elements inside of it."""
    kind, notes = field.kind, field.notes
    if field.element is not None:
        yield from _array(path, field, value, open_arrays)
    elif kind in (TIME, DURATION):
        is_time = kind == TIME
        unit = "" if is_time else "s"
        yield FieldView(path, FieldKind.VALUE, kind, seconds(value), is_time=is_time, unit=unit)
    elif field.is_message:
        yield FieldView(path, FieldKind.GROUP, kind)
        yield from _fields(value, f"{path}.", open_arrays)
    else:
        shown = _shown(value, kind)
        names = notes.names.get(field.name)
        constant = names.get(shown, "") if names and type(shown) is int else ""
        unit = notes.units.get(field.name, "")
        yield FieldView(path, FieldKind.VALUE, field.type, shown, unit=unit, constant=constant)


def _array(
    path: str, field: FieldType, value: Any, open_arrays: Mapping[str, int]
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
        unit=field.notes.units.get(field.name, ""),
        least=least,  # type: ignore[arg-type]  # numbers stay numbers
        greatest=greatest,  # type: ignore[arg-type]
        nan=summary.nan,
        first=summary.first,
        is_open=begin is not None,
    )
    if begin is None:
        return
    shown = shown_elements(begin, summary.length)
    element_type = _field_type(field.name, element, field.notes)
    for index, item in zip(shown, as_list(value[shown.start : shown.stop]), strict=True):
        yield from _row(f"{path}[{index}]", element_type, item, open_arrays)
    if len(shown) < summary.length:
        yield FieldView(f"{path}[]", FieldKind.MORE, "", summary.length)


def shown_elements(begin: int, length: int) -> range:
    """Return the numbers of the elements that an open array shows: 20, or all of a shorter array.

    Args:
        begin: The number of the first one, which is moved so that no element is missing at the end.
        length: The length of the array.
    """
    begin = max(min(begin, length - SHOWN_ELEMENTS), 0)
    return range(begin, min(begin + SHOWN_ELEMENTS, length))


def seconds(value: Any) -> float:
    """Return a Time or a Duration of builtin_interfaces as a number of seconds."""
    return float(value.sec + value.nanosec / 1e9)


def _shown(value: Any, kind: str) -> bool | float | str:
    """Return a primitive value as it is shown: a long text is cut, a float32 has few digits."""
    shown: bool | float | str = primitive(value, kind)
    return shortened(shown) if isinstance(shown, str) else shown
