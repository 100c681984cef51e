"""The line of a launch file that an object was made in."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import NamedTuple

_STAND_INS = str(Path(__file__).parent)


class Place(NamedTuple):
    """A line of a file."""

    file: str
    line: int


_elements: list[Place] = []  # Of an XML or YAML file, each within the one before it.


@contextmanager
def at(place: Place) -> Iterator[None]:
    """Have what is made inside this context made in the line of an element."""
    _elements.append(place)
    try:
        yield
    finally:
        _elements.pop()


def calling_place() -> Place:
    """Return the line of the element that is read, or else of the nearest caller's launch file.

    `Place("", 0)` stands for none.
    """
    if _elements:
        return _elements[-1]
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.startswith(_STAND_INS):
        frame = frame.f_back
    return Place("", 0) if frame is None else Place(frame.f_code.co_filename, frame.f_lineno)
