"""How often something is heard, measured, so that a slow robot is not called lost."""

from __future__ import annotations

from typing import NamedTuple

_MEASURED = 5  # intervals, of which the median is the period
LEAST_SILENCE = 2.5  # s


class Period(NamedTuple):
    """The intervals (s) between the first messages, and when the last one came (monotonic s).

    It stays as it was measured: of a link that grows slower and slower the silence must be seen.
    """

    intervals: tuple[float, ...] = ()
    last: float | None = None

    def heard(self, now: float) -> Period:
        """With one more message."""
        if self.last is None or len(self.intervals) == _MEASURED:
            return Period(self.intervals, now)
        return Period((*self.intervals, now - self.last), now)

    @property
    def seconds(self) -> float | None:
        """The period in s, of two in the middle the longer; None before two messages."""
        if not self.intervals:
            return None
        return sorted(self.intervals)[len(self.intervals) // 2]


def is_silent(received: float | None, period: float | None, now: float) -> bool:
    """True when nothing was heard for three periods, at least 2.5 s; unknown: not judged."""
    if received is None or period is None:
        return False
    return now - received > max(3 * period, LEAST_SILENCE)
