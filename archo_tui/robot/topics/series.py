"""A minute of the values of one field, for the curves of a topic that is open, and their range."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left
from typing import NamedTuple

from archo_tui.robot.state.topic import Curve, Range

SPAN = 60.0  # Seconds of values.
PER_SECOND = 10  # Least and greatest of a field are kept for each tenth of a second.
_KEPT = int(SPAN) * PER_SECOND
_SLACK = 100  # Samples beyond _KEPT, so that not every new one moves all others.
# Seconds that a value holds, so that a topic of 1 Hz has no gaps, though a message comes late.
_HOLDS = 1.5
_LATE = 1.0  # Seconds after which no value of a time comes any more.
_CURVES = 2  # Curves of different lengths that are remembered: beside the field, and its plot.


class _KnownCurve(NamedTuple):
    """A curve that was returned, kept so that its columns need not be computed again."""

    oldest: int  # The number of its first column, counted from the time 0.0.
    settled: int  # The number of the first column that may still change.
    values: list[Range | None]  # The range of values in each column; None without a value.


class FieldHistory:
    """The values of one field in the last minute, and their range since the first one."""

    def __init__(self) -> None:
        self.least, self.greatest = math.inf, -math.inf
        self._tenths = array("q")
        self._least, self._greatest = array("d"), array("d")
        self._curves: dict[int, _KnownCurve] = {}  # By the number of columns.

    @property
    def is_empty(self) -> bool:
        """True before the first value."""
        return not self._tenths

    def add(self, tenth: int, value: float) -> None:
        """Add a finite value; of each tenth of a second the least and the greatest are kept."""
        # It is called thousands of times a second: `min` and `max` would take twice as long.
        if value < self.least:
            self.least = value
        if value > self.greatest:
            self.greatest = value
        if self._tenths and self._tenths[-1] == tenth:
            if value < self._least[-1]:
                self._least[-1] = value
            if value > self._greatest[-1]:
                self._greatest[-1] = value
            return
        self._tenths.append(tenth)
        self._least.append(value)
        self._greatest.append(value)
        if len(self._tenths) > _KEPT + _SLACK:
            del self._tenths[:-_KEPT], self._least[:-_KEPT], self._greatest[:-_KEPT]

    def curve(self, now: float, columns: int) -> Curve:
        """Return the last minute in columns of equal length, each with the range of its values.

        A value holds for 1.5 s, or until the next one; a column without a value is None. The
        columns begin at multiples of their length, so that a column that is past never changes.
        """
        width = SPAN / columns
        oldest = math.floor(now / width) - columns + 1
        known, values = self._curves.get(columns), list[Range | None]()
        if known is not None and known.oldest <= oldest:
            values = known.values[oldest - known.oldest : max(known.settled - known.oldest, 0)]
        values += self._columns(oldest + len(values), columns - len(values), width)
        if columns not in self._curves and len(self._curves) == _CURVES:
            self._curves.clear()  # The screen has another size.
        settled = math.floor((now - _LATE) / width)
        self._curves[columns] = _KnownCurve(oldest, settled, values)
        return tuple(values)

    def _columns(self, oldest: int, columns: int, width: float) -> list[Range | None]:
        """Return the ranges of some columns; None for a column without a value."""
        found: list[Range | None] = [None] * columns
        first = bisect_left(self._tenths, math.floor((oldest * width - _HOLDS) * PER_SECOND))
        times = [tenth / PER_SECOND for tenth in self._tenths[first:]]
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
        return found
