"""The values of one number over time, for curves: least and greatest of each part of a second."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right

from archo_tui.robot.state.topic import Range

# Where columns are shorter than a second, a value fills those of so many seconds, so that a topic
# of 1 Hz has no gaps, though a message comes late.
_HOLDS = 1.5
_SLACK = 100  # Parts beyond those that are kept, so that not every new one moves all others.


class Series:
    """The last values of one number, and their range since the first one."""

    def __init__(self, per_second: int, kept: int) -> None:
        """Keep so many parts of a second, the newest; `per_second` of them are a second."""
        self.least, self.greatest = math.inf, -math.inf
        self._per_second, self._kept = per_second, kept
        self._parts = array("q")  # Their numbers, counted from the time 0.0.
        self._least, self._greatest = array("d"), array("d")

    @property
    def is_empty(self) -> bool:
        """True before the first value."""
        return not self._parts

    def add(self, part: int, value: float) -> None:
        """Add a finite value at a part of a second, by its number; earlier ones do not follow."""
        # It is called thousands of times a second: `min` and `max` would take twice as long.
        if value < self.least:
            self.least = value
        if value > self.greatest:
            self.greatest = value
        if self._parts and self._parts[-1] == part:
            if value < self._least[-1]:
                self._least[-1] = value
            if value > self._greatest[-1]:
                self._greatest[-1] = value
            return
        self._least.append(value)
        self._greatest.append(value)
        self._parts.append(part)  # Last: a replay is drawn while another thread reads it.
        if len(self._parts) > self._kept + _SLACK:
            for of in (self._parts, self._least, self._greatest):
                del of[: -self._kept]

    def curve(self, now: float, span: float, columns: int) -> tuple[Range | None, ...]:
        """Return the last `span` seconds in columns, each with the range of its values, or None.

        The columns begin at multiples of their length, so that a column that is past never changes.
        """
        width = span / columns
        oldest = math.floor(now / width) - columns + 1
        found: list[Range | None] = [None] * columns
        holds = _HOLDS if width < 1.0 else 0.0
        begin = bisect_left(self._parts, math.floor((oldest * width - holds) * self._per_second))
        end = bisect_right(self._parts, math.floor(now * self._per_second))
        times = [part / self._per_second for part in self._parts[begin:end]]
        places = [max(math.floor(time / width) - oldest, -1) for time in times]
        for number, (time, place) in enumerate(zip(times, places, strict=True)):
            low, high = self._least[begin + number], self._greatest[begin + number]
            if 0 <= place < columns:
                both = found[place] or (low, high)
                found[place] = min(both[0], low), max(both[1], high)
            until = math.floor((time + holds) / width) - oldest + 1
            if number + 1 < len(places):
                until = min(until, places[number + 1])
            for held in range(max(place + 1, 0), min(until, columns)):
                found[held] = low, high
        return tuple(found)
