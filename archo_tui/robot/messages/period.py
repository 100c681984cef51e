"""The measured periods of messages, by which silence is judged: a slow robot is not lost."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple, TypeGuard

from archo_tui.base.clock import Monotonic

# All of them our choice; times are in seconds.
LEAST_SILENCE = 2.5  # A shorter silence is never judged.
UNMEASURED = 90.0  # Silence allowed before the period is known: longer than most topics' periods.
LONGEST_SET = 10.0  # A parameter with a larger value is not taken for a period.
_ALIKE = 0.1  # A period that differs from a parameter by less than this share may be set by it.
_MAYBE_A_BURST = 15.0  # Silence allowed after a few quick messages, longer than most bursts' gaps.
_FEW = 3  # So many intervals may be one burst.
_KEPT = 50  # Intervals.
_OTHER = 1.25  # An interval that is so many times as long as another is not so by chance.
_REGULAR = 3  # So many silences in a row, of about one length and as far apart, are typical.
_AS_LONG = 1.1  # The longest of them may be so many times as long as the shortest.
_FORGOTTEN = 3  # So many times as long without a pause as from one to the next, and it is none.
_NOTED = 0.1  # Messages that follow faster are not recorded, once the period is measured.


class _Silence(NamedTuple):
    """A silence, or one that has become typical."""

    end: float  # In monotonic seconds.
    length: float  # In seconds.
    cycle: float = 0.0  # Seconds from the end of one to that of the next, of a typical one.


class Period(NamedTuple):
    """The measured period of one topic; immutable.

    It is the interval at which half of the last time is reached, in order of length: so a burst
    counts as one message. A silence is no interval, so a link that becomes slower is noticed each
    time; but silences of the same length, three in a row and equally far apart, as between long
    bursts, are typical: those of a robot that is restarted now and then are not.
    """

    intervals: tuple[float, ...] = ()  # The last ones between messages, in seconds.
    last: float | None = None  # When the last message came, in monotonic seconds.
    # The period in seconds from before, which holds until it is measured; or None.
    known: float | None = None
    measured: float | None = None  # In seconds; it does not follow small changes.
    silences: tuple[_Silence, ...] = ()  # The last ones, of which none is typical.
    pause: _Silence | None = None  # The last one, if silences are typical.

    def measured_again(self, old: object, new: object) -> Period:
        """Return a period to be measured anew, since a parameter has changed from `old` to `new`.

        Until then the present one holds, or a longer `new` if `old` was about the present one.
        """
        seconds = self.typical or self.seconds
        if seconds is None or not (is_number(old) and is_number(new)):
            return Period(known=seconds)
        if abs(seconds - old) <= _ALIKE * old:
            seconds = max(seconds, min(float(new), LONGEST_SET))
        return Period(known=seconds)

    def without_pauses(self) -> Period:
        """Return the period with every silence forgotten: another publisher may have no such."""
        after = self._replace(silences=(), pause=None)
        return after._replace(measured=after._measure(self.intervals))

    def with_message_at(self, now: float) -> Period:
        """Return the period with one more message at `now`, in monotonic seconds."""
        if self.last is None:
            return self._replace(last=now)
        interval = now - self.last
        if self.measured is not None and interval < _NOTED:
            return self
        if is_silent(self.last, self.measured, now, None):
            silences = (*self.silences, _Silence(now, interval))[-_REGULAR:]
            pause = _typical_pause(silences)
            if pause is None:
                return self._replace(last=now, silences=silences)
            return self._replace(last=now, measured=pause.length, pause=pause, silences=())
        intervals = (*self.intervals, interval)[-_KEPT:]
        pause = self.pause
        if pause is not None and interval * _AS_LONG >= pause.length:
            pause = pause._replace(end=now)
        elif pause is not None and now - pause.end > _FORGOTTEN * pause.cycle:
            pause = None
        after = self._replace(last=now, intervals=intervals, pause=pause)
        return after._replace(measured=after._measure(intervals))

    def _measure(self, intervals: tuple[float, ...]) -> float | None:
        passed, whole = 0.0, sum(intervals)
        if whole < LEAST_SILENCE:  # The first messages may be one burst.
            return self.measured
        for interval in sorted(intervals):
            passed += interval
            if passed >= whole / 2:
                break
        typical, before = max(interval, self.pause.length if self.pause else 0.0), self.measured
        is_other = before is None or not before / _OTHER <= typical <= before * _OTHER
        return typical if is_other else before  # Each change would be shown.

    @property
    def seconds(self) -> float | None:
        """The median of the intervals in seconds; before two messages, `known`, or None."""
        if not self.intervals:
            return self.known
        return sorted(self.intervals)[len(self.intervals) // 2]

    @property
    def typical(self) -> float | None:
        """The interval in seconds by which silence is judged; None if none is known."""
        return self.known if self.measured is None else self.measured

    @property
    def grace(self) -> float:
        """The silence in seconds that is allowed before the typical interval is known: 15 or 90."""
        return _MAYBE_A_BURST if len(self.intervals) >= _FEW else UNMEASURED


def _typical_pause(silences: tuple[_Silence, ...]) -> _Silence | None:
    """Return the longest of silences that are alike and equally far apart; None if they are not."""
    if len(silences) < _REGULAR:
        return None
    lengths = [silence.length for silence in silences]
    cycles = [later.end - earlier.end for earlier, later in pairwise(silences)]
    if any(max(spans) > _AS_LONG * min(spans) for spans in (lengths, cycles)):
        return None
    return _Silence(silences[-1].end, max(lengths), max(cycles))


class Pause(NamedTuple):
    """The pauses of this process, as when it was suspended; it receives nothing during a pause.

    Pauses that follow each other count as one, or a process that pauses again and again would never
    notice a silence.
    """

    checked: float | None = None  # When `checked_at` was called last, in monotonic seconds.
    is_over: bool = True  # False if a pause was found at the last call.
    resumed: float = float("-inf")  # The end of the last pause, in monotonic seconds.

    def checked_at(self, now: float) -> Pause:
        """Return the pauses up to `now`; more than 2.5 s since the last call are a pause."""
        paused = self.checked is not None and now - self.checked > LEAST_SILENCE
        resumed = now if paused and self.is_over else self.resumed
        return Pause(now, not paused, resumed)


def is_number(value: object) -> TypeGuard[float]:
    """Return True for a number that is no bool."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def is_silent(
    received: float | None, period: float | None, now: float, grace: float | None
) -> bool:
    """Return True if no message came for three periods, at least 2.5 s, since the last one.

    While the period is not known, for `grace` seconds; None: then nothing counts as silence.
    """
    if received is None:
        return False
    longest = grace if period is None else max(3 * period, LEAST_SILENCE)
    return longest is not None and now - received > longest


RATE_INTERVALS = 3  # Fewer intervals tell no rate.
_SMOOTHING = 0.2  # Our choice: the weight of the newest interval in a rate.


class MessageRate(NamedTuple):
    """The present rate of messages; immutable. After a silence it is measured anew."""

    heard: Monotonic  # When the last message came, in monotonic seconds.
    interval: float | None = None  # The smoothed interval in seconds; None before two messages.
    intervals: int = RATE_INTERVALS  # How many intervals were measured, at most RATE_INTERVALS.

    def with_message_at(self, now: float) -> MessageRate:
        """Return the rate with one more message at `now`, in monotonic seconds."""
        if self.is_silent(now):
            return MessageRate(now)
        since = now - self.heard
        if since <= 0:
            return self
        if self.interval is None:
            return MessageRate(now, since, 1)
        interval = self.interval + _SMOOTHING * (since - self.interval)
        return MessageRate(now, interval, min(self.intervals + 1, RATE_INTERVALS))

    @property
    def hertz(self) -> float | None:
        """The messages in a second; None before three intervals: two messages may come at once."""
        return 1 / self.interval if self.interval and self.intervals >= RATE_INTERVALS else None

    def hertz_at(self, now: float) -> float | None:
        """Return `hertz`, but None while the topic is silent."""
        return None if self.is_silent(now) else self.hertz

    def is_silent(self, now: float) -> bool:
        """Return True if no message came for three intervals, and at least 2.5 s."""
        return is_silent(self.heard, self.interval, now, None)
