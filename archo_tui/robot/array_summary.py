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
    """An array in place of which few values are shown.

    Attributes:
        type: The type of its elements and its length, as .msg files write them: `float32[360]`.
        length: The number of its elements.
        least: The least number; None for elements that are no numbers, or all NaN.
        greatest: The greatest number; None as for `least`.
        nan: The number of elements that are NaN.
        first: For an array of bytes, the first ones in hexadecimal.
    """

    type: str
    length: int
    least: float | None = None
    greatest: float | None = None
    nan: int = 0
    first: str = ""


def summarize(value: Any, element: str) -> ArraySummary:
    """Return the summary of an array. It takes long for a large one.

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
    """Return the elements of an array as Python's own values."""
    found: list[Any] = value.tolist() if hasattr(value, "tolist") else list(value)
    return found
