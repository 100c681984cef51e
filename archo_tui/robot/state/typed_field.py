"""A field of a goal or a request, as a form asks for it."""

from __future__ import annotations

from typing import Any, NamedTuple


class TypedField(NamedTuple):
    """A field of a goal or a request with its type: a primitive, or an array of anything.

    Attributes:
        path: The dotted path of the field.
        type: Its type as rclpy names it: `int32`, `double`, `string<10>`, `sequence<int32>`.
        default: Its default value.
    """

    path: str
    type: str
    default: Any
