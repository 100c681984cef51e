"""The fields of a message as rows: values, nested messages, and arrays by their summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

from archo_tui.robot.array_summary import listed, summarize
from archo_tui.robot.definitions import ros2msg_type
from archo_tui.robot.field_notes import FieldNotes, notes_of
from archo_tui.robot.fields import NESTED, element_of
from archo_tui.robot.message_classes import EMPTY, name_of
from archo_tui.robot.message_text import primitive, shortened
from archo_tui.robot.state import SHOWN_ELEMENTS, FieldKind, FieldView

MAX_FIELDS = 2_000  # Rows of one message.
_TIME, _DURATION = "builtin_interfaces/Time", "builtin_interfaces/Duration"


def field_rows(message: Any, open_arrays: Mapping[str, int]) -> tuple[list[FieldView], bool]:
    """Return the rows of a message, and True if it has more of them than `MAX_FIELDS`.

    It takes long for a large message, and reads the files of the types that it sees first.

    Args:
        message: The message.
        open_arrays: The arrays whose elements have rows, too, by path, each with the number of
            the first element.
    """
    found = list(islice(_fields(message, "", open_arrays), MAX_FIELDS + 1))
    return found[:MAX_FIELDS], len(found) > MAX_FIELDS


def _fields(message: Any, before: str, open_arrays: Mapping[str, int]) -> Iterator[FieldView]:
    """Yield the rows of a message whose path with its dot is `before`."""
    notes = notes_of(name_of(type(message)))
    for name, kind in message.get_fields_and_field_types().items():
        if name != EMPTY:
            yield from _row(
                f"{before}{name}", kind, getattr(message, name), name, notes, open_arrays
            )


def _row(
    path: str,
    kind: str,
    value: Any,
    name: str,
    notes: FieldNotes,
    open_arrays: Mapping[str, int],
) -> Iterator[FieldView]:
    """Yield the row of a field, and those below it.

    Args:
        path: Its path.
        kind: Its type, as rosidl writes it.
        value: Its value.
        name: The name of the field whose notes hold for it.
        notes: The notes on the type that has the field.
        open_arrays: As for `field_rows`.
    """
    element = element_of(kind)
    if element is not None:
        yield from _array(path, element, value, name, notes, open_arrays)
    elif kind in (_TIME, _DURATION):
        seconds = value.sec + value.nanosec / 1e9
        is_time = kind == _TIME
        unit = "" if is_time else "s"
        yield FieldView(path, FieldKind.VALUE, kind, seconds, is_time=is_time, unit=unit)
    elif NESTED.fullmatch(kind):
        yield FieldView(path, FieldKind.GROUP, kind)
        yield from _fields(value, f"{path}.", open_arrays)
    else:
        shown = _shown(value, kind)
        names = notes.names.get(name)
        constant = names.get(shown, "") if names and type(shown) is int else ""
        unit = notes.units.get(name, "")
        kind = ros2msg_type(kind)
        yield FieldView(path, FieldKind.VALUE, kind, shown, unit=unit, constant=constant)


def _array(
    path: str,
    element: str,
    value: Any,
    name: str,
    notes: FieldNotes,
    open_arrays: Mapping[str, int],
) -> Iterator[FieldView]:
    """Yield the row of an array, and of its elements if it is open."""
    begin, summary = open_arrays.get(path), summarize(value, element)
    least, greatest = (
        None if end is None else _shown(end, element) for end in (summary.least, summary.greatest)
    )
    yield FieldView(
        path,
        FieldKind.ARRAY,
        summary.type,
        unit=notes.units.get(name, ""),
        least=least,  # type: ignore[arg-type]  # numbers stay numbers
        greatest=greatest,  # type: ignore[arg-type]
        nan=summary.nan,
        first=summary.first,
        is_open=begin is not None,
    )
    if begin is None:
        return
    end = begin + SHOWN_ELEMENTS
    for index, item in enumerate(listed(value[begin:end]), begin):
        yield from _row(f"{path}[{index}]", element, item, name, notes, open_arrays)
    if begin or summary.length > end:
        yield FieldView(f"{path}[]", FieldKind.MORE, "", summary.length)


def _shown(value: Any, kind: str) -> bool | float | str:
    """Return a primitive value as it is shown."""
    shown: bool | float | str = primitive(value, kind)
    return shortened(shown) if isinstance(shown, str) else shown
