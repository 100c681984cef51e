"""How often something is heard, measured, so that a slow robot is not called lost."""

from __future__ import annotations

from typing import NamedTuple, TypeGuard

_MEASURED = 5  # intervals, of which the median is the period
LEAST_SILENCE = 2.5  # s
UNMEASURED = 30.0  # s of silence before the period is known: longer than that of most topics
LONGEST_SET = UNMEASURED / 3  # s; a longer period that a parameter seems to be is not believed
_ALIKE = 0.1  # of a parameter's value by which a period may differ from it
_SMOOTHING = 0.2  # weight of the newest interval in a pace


class Period(NamedTuple):
    """The intervals (s) between the first messages, and when the last of them came (monotonic s).

    It stays as it was measured: of a link that grows slower and slower the silence must be seen.
    """

    intervals: tuple[float, ...] = ()
    last: float | None = None
    known: float | None = None  # the period (s) that holds until it is measured

    def anew(self, old: object, new: object) -> Period:
        """Return the period to be measured anew, because a parameter has changed.

        What is known stays until then. Where the parameter was the period itself, that is its new
        value if that is longer: the publisher may wait for the end of the old one.

        Args:
            old: What the parameter was; None: it is of another node than the publisher.
            new: What it is.
        """
        seconds = self.seconds
        if seconds is None or not (is_number(old) and is_number(new)):
            return Period(known=seconds)
        if abs(seconds - old) <= _ALIKE * old:
            seconds = max(seconds, min(float(new), LONGEST_SET))
        return Period(known=seconds)

    def heard(self, now: float) -> Period:
        """With one more message."""
        if len(self.intervals) == _MEASURED:
            return self
        if self.last is None:
            return self._replace(last=now)
        return self._replace(intervals=(*self.intervals, now - self.last), last=now)

    @property
    def seconds(self) -> float | None:
        """The period in s, of two in the middle the longer; before two messages what is known."""
        if not self.intervals:
            return self.known
        return sorted(self.intervals)[len(self.intervals) // 2]


class Pause(NamedTuple):
    """Whether this process stood still, as one that was suspended: it could hear nobody then.

    One that stands still again and again has one such pause: it is not to stay silent.
    """

    looked: float | None = None  # the last time, monotonic s
    is_over: bool = True
    resumed: float = float("-inf")  # behind a pause, of which silence says nothing; monotonic s

    def look(self, now: float) -> Pause:
        """Return what is known at that time, given that somebody looks every second or so."""
        paused = self.looked is not None and now - self.looked > LEAST_SILENCE
        resumed = now if paused and self.is_over else self.resumed
        return Pause(now, not paused, resumed)


def is_number(value: object) -> TypeGuard[float]:
    """Return whether it is a number, and no truth value."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


class Pace(NamedTuple):
    """How often something is heard now; starts over after a silence."""

    heard: float  # the last time, monotonic s
    interval: float | None = None  # s, smoothed; None before two messages

    def again(self, now: float) -> Pace:
        """With one more message."""
        if self.is_silent(now):
            return Pace(now)
        since = now - self.heard
        if since <= 0:
            return self
        before = since if self.interval is None else self.interval
        return Pace(now, before + _SMOOTHING * (since - before))

    @property
    def rate(self) -> float | None:
        """In Hz."""
        return 1 / self.interval if self.interval else None

    def is_silent(self, now: float) -> bool:
        """True when nothing was heard for three intervals, at least 2.5 s; one was not: no."""
        return is_silent(self.heard, self.interval, now, None)


def is_silent(
    received: float | None, period: float | None, now: float, grace: float | None
) -> bool:
    """True when nothing was heard for three periods, at least 2.5 s.

    Before the period is known: for `grace` s; None: it is not judged.
    """
    if received is None:
        return False
    longest = grace if period is None else max(3 * period, LEAST_SILENCE)
    return longest is not None and now - received > longest
