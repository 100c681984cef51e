"""How often something is heard, measured, so that a slow robot is not called lost."""

from __future__ import annotations

from typing import NamedTuple, TypeGuard

_MEASURED = 5  # intervals, of which the median is the period
LEAST_SILENCE = 2.5  # s
UNMEASURED = 90.0  # s of silence before the period is known: longer than that of most topics
LONGEST_SET = 10.0  # s; a longer period that a parameter seems to be is not believed
_ALIKE = 0.1  # of a parameter's value by which a period may differ from it
_SMOOTHING = 0.2  # weight of the newest interval in a pace
_MAYBE_A_BURST = 15.0  # s of silence behind it; longer than between most bursts
_FEW = 3  # intervals that may be a burst
_DENSE = LEAST_SILENCE / 3  # s; intervals up to that make no difference to LEAST_SILENCE
_LEARNT = 10.0  # s of messages at least, by which it is known what is typical of a topic
_MOST = 20  # longer intervals by which it is known at the latest
_LONGER = 1.25  # times as long as another interval is no chance
_GROWING = 3  # intervals in a row, each longer than the one before: the link grows slower
_REGULAR = 3  # silences in a row that are as long as each other, until they are typical
_NOTED = 0.1  # s between two messages that are noted, once the period is learnt
_AS_LONG = 1.1  # times as long as the shortest of them the longest may be


class Period(NamedTuple):
    """The intervals (s) between the first messages, and when the last of them came (monotonic s).

    It stays as it was measured: of a link that grows slower and slower the silence must be seen.
    """

    intervals: tuple[float, ...] = ()
    last: float | None = None
    known: float | None = None  # the period (s) that holds until it is measured
    dense: float = 0.0  # s in all of the intervals up to _DENSE
    gaps: tuple[float, ...] = ()  # s; the longer intervals
    learnt: float | None = None  # what is typical, in s; None: that is being learnt
    silences: tuple[float, ...] = ()  # s; the last intervals that were longer than is typical

    def measured_again(self, old: object, new: object) -> Period:
        """Return the period to be measured anew, because a parameter has changed.

        What is known stays until then. Where the parameter was the period itself, that is its new
        value if that is longer: the publisher may wait for the end of the old one.

        Args:
            old: What the parameter was; None: it is of another node than the publisher.
            new: What it is.
        """
        seconds = self.typical or self.seconds
        if seconds is None or not (is_number(old) and is_number(new)):
            return Period(known=seconds)
        if abs(seconds - old) <= _ALIKE * old:
            seconds = max(seconds, min(float(new), LONGEST_SET))
        return Period(known=seconds)

    def heard(self, now: float) -> Period:
        """Return the period with one more message at `now` (monotonic s)."""
        if self.last is None:
            return self._replace(last=now)
        interval = now - self.last
        if self.learnt is not None:
            # Of messages that come fast not each is noted: of silences that is not missed.
            return self if interval < _NOTED else self._with_typical(interval, now)
        intervals = (*self.intervals, interval)[:_MEASURED]
        learning = self._replace(intervals=intervals, last=now)
        if interval <= _DENSE:
            learning = learning._replace(dense=self.dense + interval)
        else:
            learning = learning._replace(gaps=(*self.gaps, interval))
        if not learning._is_sure:
            return learning
        return learning._replace(learnt=learning._middle)._with_typical(interval, now)

    def _with_typical(self, interval: float, now: float) -> Period:
        """Return the period with a message, when it is known what is typical.

        Silences that come regularly become typical, as those between long bursts.
        """
        assert self.learnt is not None
        if interval <= max(3 * self.learnt, LEAST_SILENCE):
            return self._replace(last=now)
        silences = (*self.silences, interval)[-_REGULAR:]
        if len(silences) == _REGULAR and max(silences) <= _AS_LONG * min(silences):
            return self._replace(last=now, learnt=max(silences), silences=())
        return self._replace(last=now, silences=silences)

    @property
    def _is_sure(self) -> bool:
        """Return whether enough was heard to know what is typical: one long gap is a hiccup."""
        if len(self.gaps) >= _MOST:
            return True
        if self._span < _LEARNT or len(self.intervals) < _MEASURED:
            return False
        middle = self._middle
        return middle <= _DENSE or sum(gap * _LONGER >= middle for gap in self.gaps) > 1

    @property
    def _span(self) -> float:
        """The time from the first message to the last, in s."""
        return self.dense + sum(self.gaps)

    @property
    def _middle(self) -> float:
        """The interval in s in which the middle of the time lies; so a burst counts as one message.

        The last intervals do not count while they grow.
        """
        gaps = list(self.gaps)
        grown = 0
        while grown < len(gaps) - 1 and gaps[-1 - grown] > _LONGER * gaps[-2 - grown]:
            grown += 1
        if grown >= _GROWING:
            gaps = gaps[:-grown]
        passed, half = self.dense, (self.dense + sum(gaps)) / 2
        for gap in sorted(gaps):
            if passed >= half:
                break
            passed += gap
            if passed >= half:
                return gap
        # not the mean, which differs with each message: that would be news
        return min(self.seconds or 0.0, _DENSE)

    @property
    def seconds(self) -> float | None:
        """The period in s, of two in the middle the longer; before two messages what is known."""
        if not self.intervals:
            return self.known
        return sorted(self.intervals)[len(self.intervals) // 2]

    @property
    def typical(self) -> float | None:
        """The interval in s by which silence is judged: that in which the middle of the time lies.

        The first messages may be a burst, and say nothing yet: what is known holds; None: nothing.
        """
        if self.learnt is not None:
            return self.learnt
        return self.known if self._span < LEAST_SILENCE else self._middle

    @property
    def grace(self) -> float:
        """The silence in s that is allowed while nothing is typical yet.

        Several messages at once are a burst, or the first words of a robot that then died.
        """
        return _MAYBE_A_BURST if len(self.intervals) >= _FEW else UNMEASURED


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
