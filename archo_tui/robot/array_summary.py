"""A long array in a few values: its type and length, and its range or its first bytes."""

from __future__ import annotations

from typing import Any, NamedTuple

from archo_tui.robot.definitions import ros2msg_type
from archo_tui.robot.fields import NESTED

_FIRST_BYTES = 16
_CHUNK = 50_000  # Elements that are compared at once, so that other threads get their turn.
_BYTES = ("uint8", "octet")
_NOT_NUMBERS = ("boolean", "string", "wstring")


class ArraySummary(NamedTuple):
    """A summary of an array, shown in place of its elements.

    Attributes:
        type: The type of its elements and its length, as .msg files write them: `float32[360]`.
        length: The number of its elements.
        least: The least number; None if the elements are no numbers, are bytes, or are all NaN, or
            if there are none.
        greatest: The greatest number; None as for `least`.
        nan: The number of elements that are NaN; 0 if they are no numbers.
        first: The first 16 bytes in hexadecimal, for an array of `uint8` or `byte`; else "".
    """

    type: str
    length: int
    least: float | None = None
    greatest: float | None = None
    nan: int = 0
    first: str = ""


def summarize(value: Any, element: str) -> ArraySummary:
    """Return the summary of an array.

    A large array takes long: call this on no thread that others wait for.

    Args:
        value: The array as rclpy has it: a list, an `array.array`, a NumPy array.
        element: The type of its elements, as rosidl writes it.
    """
    kind = f"{ros2msg_type(element)}[{len(value)}]"
    if element in _BYTES:
        first = value[:_FIRST_BYTES]
        joined = b"".join(first) if element == "octet" else bytes(as_list(first))
        return ArraySummary(kind, len(value), first=joined.hex(" "))
    if NESTED.fullmatch(element) or element.partition("<")[0] in _NOT_NUMBERS:
        return ArraySummary(kind, len(value))
    ends: list[float] = []
    nan = 0
    for start in range(0, len(value), _CHUNK):
        chunk = as_list(value[start : start + _CHUNK])
        numbers = [number for number in chunk if number == number]
        nan += len(chunk) - len(numbers)
        ends += [min(numbers), max(numbers)] if numbers else []
    return ArraySummary(kind, len(value), min(ends, default=None), max(ends, default=None), nan)


def as_list(value: Any) -> list[Any]:
    """Return the elements of an array in a list; numbers of NumPy become Python's own."""
    found: list[Any] = value.tolist() if hasattr(value, "tolist") else list(value)
    return found
