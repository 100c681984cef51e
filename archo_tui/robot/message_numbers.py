"""The numbers of a message by path, read at once, which is far cheaper than to make its rows.

Of a topic that is open, the rows are made for each picture, but the numbers are read from each
message that is decoded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from operator import attrgetter
from typing import Any

from archo_tui.errors import ArchoError
from archo_tui.robot.array_summary import as_list
from archo_tui.robot.fields import NESTED, element_of
from archo_tui.robot.message_fields import (
    DURATION,
    MAX_FIELDS,
    TIME,
    field_types,
    seconds,
    shown_elements,
)
from archo_tui.robot.message_text import find_field
from archo_tui.robot.values import INTEGERS

_NUMBERS = {*INTEGERS, "float", "double", "boolean"}


class MessageNumbers:
    """A reader of the numbers in messages of one class. Bools and Durations count as numbers.

    Attributes:
        paths: The dotted paths of the numbers outside of arrays, at most `MAX_FIELDS`.
    """

    def __init__(self, message: Any) -> None:
        """Create a reader for the class of a message.

        Args:
            message: A message of that class; the first time, the interface files of its types are
                read.
        """
        found = dict(_numbers(message, ""))
        self.paths = tuple(found)[:MAX_FIELDS]
        self._get = attrgetter(*self.paths) if self.paths else None
        # Most values are numbers already.
        self._convert = [
            (place, convert) for place, path in enumerate(self.paths) if (convert := found[path])
        ]

    def read(self, message: Any) -> tuple[Any, ...]:
        """Return the numbers of a message of the same class, in the order of `paths`.

        A Duration is in seconds.
        """
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


def element_numbers(message: Any, open_arrays: Mapping[str, int]) -> Iterator[tuple[str, Any]]:
    """Yield path and value of the numbers in those elements of open arrays that are shown.

    An array that the message does not have is left out.

    Args:
        message: The message.
        open_arrays: The number of the first shown element, by the path of the array.
    """
    for path, begin in open_arrays.items():
        try:
            array = find_field(message, path)
        except ArchoError:  # It was an element of an array that has become shorter.
            continue
        element = element_of(array.type) or ""
        shown = shown_elements(begin, len(array.value))
        items = zip(shown, as_list(array.value[shown.start : shown.stop]), strict=True)
        convert = _converter(element)
        for index, item in items:
            where = f"{path}[{index}]"
            if element in _NUMBERS or element == DURATION:
                yield where, convert(item) if convert else item
            elif element != TIME and NESTED.fullmatch(element):
                for inner, convert_inner in _numbers(item, ""):
                    value = attrgetter(inner)(item)
                    yield f"{where}.{inner}", convert_inner(value) if convert_inner else value


def _numbers(message: Any, before: str) -> Iterator[tuple[str, Callable[[Any], float] | None]]:
    """Yield the path of each number outside of arrays, and the function that converts its value.

    The function is None where the value is a number already.
    """
    for field in field_types(message):
        path = f"{before}{field.name}"
        if field.kind in _NUMBERS or field.kind == DURATION:
            yield path, _converter(field.kind)
        elif field.is_message and field.kind != TIME:
            yield from _numbers(getattr(message, field.name), f"{path}.")


def _converter(kind: str) -> Callable[[Any], float] | None:
    if kind == "octet":
        return lambda value: int(value[0])
    return seconds if kind == DURATION else None
