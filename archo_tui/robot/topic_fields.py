"""The memory of a topic's fields while somebody looks at it: ranges, and a minute of values.

Pure: messages and their times come in, rows go out.
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left
from collections.abc import Mapping
from typing import Any

from archo_tui.robot.message_fields import field_rows
from archo_tui.robot.state import Curve, FieldView, Range, TopicRequest

SPAN = 60.0  # Seconds of values.
_PER_SECOND = 10  # Least and greatest of a field are kept for each tenth of a second.
_KEPT = int(SPAN) * _PER_SECOND
_SLACK = 100  # Samples beyond _KEPT, so that not every new one moves all others.
# Seconds that a value holds, so that a topic of 1 Hz has no gaps, though a message comes late.
_HOLDS = 1.5


class FieldHistory:
    """The values of one field in the last minute, and its range since the topic was opened."""

    def __init__(self) -> None:
        self.least, self.greatest = math.inf, -math.inf
        self._tenths = array("q")
        self._least, self._greatest = array("d"), array("d")

    def add(self, time: float, value: float) -> None:
        """Add a finite value.

        Args:
            time: Its time in seconds, not before the last one.
            value: The value.
        """
        self.least, self.greatest = min(self.least, value), max(self.greatest, value)
        tenth = math.floor(time * _PER_SECOND)
        if self._tenths and self._tenths[-1] == tenth:
            self._least[-1] = min(self._least[-1], value)
            self._greatest[-1] = max(self._greatest[-1], value)
            return
        for column, new in (
            (self._tenths, tenth), (self._least, value), (self._greatest, value)
        ):  # fmt: skip
            column.append(new)  # type: ignore[arg-type]  # each array gets its own type
            if len(column) > _KEPT + _SLACK:
                del column[:-_KEPT]

    def curve(self, now: float, columns: int) -> Curve:
        """Return the values of the last minute in a number of columns, the newest last.

        The columns begin at multiples of their length, so that a column that is past never changes.
        """
        found: list[Range | None] = [None] * columns
        width = SPAN / columns
        newest = math.floor(now / width)
        oldest = newest - columns + 1
        first = bisect_left(self._tenths, math.floor((oldest * width - _HOLDS) * _PER_SECOND))
        times = [tenth / _PER_SECOND for tenth in self._tenths[first:]]
        places = [math.floor(time / width) - oldest for time in times]
        for number, (time, place) in enumerate(zip(times, places, strict=True), first):
            low, high = self._least[number], self._greatest[number]
            if 0 <= place < columns:
                both = found[place] or (low, high)
                found[place] = min(both[0], low), max(both[1], high)
            until = math.floor((time + _HOLDS) / width) - oldest + 1
            following = number - first + 1
            if following < len(places):
                until = min(until, places[following])
            for held in range(max(place + 1, 0), min(until, columns)):
                found[held] = low, high
        return tuple(found)


class TopicFields:
    """The fields of a topic since it was opened.

    Attributes:
        is_cut: True if the last message has more fields than are kept.
    """

    def __init__(self, units: Mapping[str, str]) -> None:
        """Know nothing yet.

        Args:
            units: The units that the robot file gives, by path.
        """
        self._units = units
        self._histories: dict[str, FieldHistory] = {}
        self._message: Any = None  # The last one.
        self._open_arrays: Mapping[str, int] = {}  # In its rows.
        self._rows: list[FieldView] = []
        self.is_cut = False

    def add(self, time: float, message: Any, open_arrays: Mapping[str, int]) -> None:
        """Take in a message. It takes long for a large one.

        Args:
            time: When it came, in seconds.
            message: The message.
            open_arrays: As for `field_rows`.
        """
        self._message = message
        self._read(open_arrays)
        for row in self._rows:
            number = row.number
            if number is not None:
                history = self._histories.get(row.path)
                if history is None:
                    history = self._histories[row.path] = FieldHistory()
                history.add(time, number)

    def _read(self, open_arrays: Mapping[str, int]) -> None:
        self._rows, self.is_cut = field_rows(self._message, open_arrays)
        self._open_arrays = open_arrays

    def rows(self, now: float, request: TopicRequest) -> tuple[FieldView, ...]:
        """Return the rows of the last message, with ranges and the curves that are visible."""
        if self._message is not None and request.open_arrays != self._open_arrays:
            self._read(request.open_arrays)
        return tuple(self._complete(row, now, request) for row in self._rows)

    def plots(self, now: float, request: TopicRequest) -> dict[str, Curve]:
        """Return the curve of each plotted field that has had a number."""
        return {
            path: self._histories[path].curve(now, request.plot_columns)
            for path in request.plotted
            if path in self._histories and request.plot_columns
        }

    def _complete(self, row: FieldView, now: float, request: TopicRequest) -> FieldView:
        """Return a row with what is known of its field besides its value."""
        unit, history = self._units.get(row.path, row.unit), self._histories.get(row.path)
        if history is None:
            return row._replace(unit=unit) if unit != row.unit else row
        is_seen = row.path in request.visible and request.curve_columns
        has_range = not isinstance(row.value, bool)
        return row._replace(
            unit=unit,
            least=history.least if has_range else None,
            greatest=history.greatest if has_range else None,
            curve=history.curve(now, request.curve_columns) if is_seen else (),
        )
