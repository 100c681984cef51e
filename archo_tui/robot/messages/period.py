"""The measured periods of messages, by which silence is judged: a slow robot is not lost."""

from __future__ import annotations

from typing import NamedTuple, TypeGuard

from archo_tui.clock import Monotonic

# All of them our choice; times are in seconds.
LEAST_SILENCE = 2.5  # A shorter silence is never judged.
UNMEASURED = 90.0  # Silence allowed before the period is known: longer than most topics' periods.
LONGEST_SET = 10.0  # A parameter with a larger value is not taken for a period.
_MEASURED = 5  # Intervals, of which the median is the period.
_ALIKE = 0.1  # A period that differs from a parameter by less than this share may be set by it.
_MAYBE_A_BURST = 15.0  # Silence allowed after a few quick messages, longer than most bursts' gaps.
_FEW = 3  # So many intervals may be one burst.
_DENSE = LEAST_SILENCE / 3  # Shorter intervals allow no less silence than LEAST_SILENCE.
_LEARNT = 10.0  # Messages for at least so long are needed to know a topic's typical interval.
_MAX_GAPS = 20  # After so many longer intervals it is known in any case.
_LONGER = 1.25  # An interval that is so many times as long as another is not so by chance.
_GROWING = 3  # So many intervals in a row, each longer than the last: the link becomes slower.
_REGULAR = 3  # So many silences in a row of about the same length become typical.
_AS_LONG = 1.1  # The longest of them may be so many times as long as the shortest.
_REGULAR_SHARE = 1 / 3  # Intervals up to this share of the learnt one contradict it ...
_REGULAR_SPAN = 2  # ... if nothing else comes for so many learnt intervals,
_REGULAR_MESSAGES = 10  # and for at least so many messages.
_NOTED = 0.1  # Messages that follow faster are not recorded, once the period is learnt.


class Period(NamedTuple):
    """The measured period of one topic; immutable.

    Once the typical interval is learnt it does not follow a link that becomes slower, so that the
    silence of such a link is noticed. Silences of the same length, three in a row, make it longer.
    Regular messages that are much more frequent show that it was learnt from outages: unless such
    silences taught it, it is learnt anew.
    """

    intervals: tuple[float, ...] = ()  # The first intervals between messages, in seconds.
    last: float | None = None  # When the last message came, in monotonic seconds.
    # The period in seconds from before, which holds until it is measured; or None.
    known: float | None = None
    dense: float = 0.0  # The sum of all intervals up to `_DENSE`, in seconds.
    gaps: tuple[float, ...] = ()  # The longer intervals, in seconds.
    learnt: float | None = None  # The typical interval in seconds; None while it is being learnt.
    # The last intervals that were longer than is typical, in seconds.
    silences: tuple[float, ...] = ()
    is_taught: bool = False  # True if silences of the same length made `learnt` longer.
    regular: int = 0  # The messages in a row that came much more often than is typical.
    regular_since: float = 0.0  # When the first of them came, in monotonic seconds.

    def measured_again(self, old: object, new: object) -> Period:
        """Return an unmeasured period in which the present one holds until it is measured again.

        For use when a parameter has changed.
        """
        seconds = self.typical or self.seconds
        if seconds is None or not (is_number(old) and is_number(new)):
            return Period(known=seconds)
        if abs(seconds - old) <= _ALIKE * old:
            seconds = max(seconds, min(float(new), LONGEST_SET))
        return Period(known=seconds)

    def with_message_at(self, now: float) -> Period:
        """Return the period with one more message at `now`, in monotonic seconds.

        Once the typical interval is learnt, a message within 0.1 s of the last one changes nothing.
        """
        if self.last is None:
            return self._replace(last=now)
        interval = now - self.last
        if self.learnt is not None:
            # Fast messages are not all recorded: that makes no difference to a silence.
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
        """Return the period with one more message, after the typical interval was learnt.

        Silences of the same length, three in a row as between long bursts, become typical.
        """
        assert self.learnt is not None
        if interval <= max(3 * self.learnt, LEAST_SILENCE):
            return self._replace(last=now)._with_regularity(interval, now)
        silences = (*self.silences, interval)[-_REGULAR:]
        if len(silences) == _REGULAR and max(silences) <= _AS_LONG * min(silences):
            return self._replace(last=now, learnt=max(silences), silences=(), is_taught=True)
        return self._replace(last=now, silences=silences, regular=0)

    def _with_regularity(self, interval: float, now: float) -> Period:
        """Return the period to be learnt anew if regular messages contradict the learnt one."""
        assert self.learnt is not None
        if self.is_taught or self.learnt <= _DENSE:
            return self
        if interval > self.learnt * _REGULAR_SHARE:
            return self._replace(regular=0)
        since = self.regular_since if self.regular else now - interval
        counted = self._replace(regular=self.regular + 1, regular_since=since)
        is_long = now - since >= _REGULAR_SPAN * self.learnt
        if is_long and counted.regular >= _REGULAR_MESSAGES:
            return Period(last=now, known=self.learnt)
        return counted

    @property
    def _is_sure(self) -> bool:
        """True if enough was received to tell the typical interval, despite a single long gap."""
        if len(self.gaps) >= _MAX_GAPS:
            return True
        if self._span < _LEARNT or len(self.intervals) < _MEASURED:
            return False
        middle = self._middle
        return middle <= _DENSE or sum(gap * _LONGER >= middle for gap in self.gaps) > 1

    @property
    def _span(self) -> float:
        """The seconds from the first message to the last."""
        return self.dense + sum(self.gaps)

    @property
    def _middle(self) -> float:
        """The interval in seconds, in order of length, at which half of the whole time is reached.

        In this way a burst counts as one message. The last intervals do not count while they grow.
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
        # The mean would change with each message, and each change would be shown.
        return min(self.seconds or 0.0, _DENSE)

    @property
    def seconds(self) -> float | None:
        """The median of the first intervals in seconds; before two messages, `known`, or None."""
        if not self.intervals:
            return self.known
        return sorted(self.intervals)[len(self.intervals) // 2]

    @property
    def typical(self) -> float | None:
        """The interval in seconds by which silence is judged; None if none is known.

        The first messages may be one burst and do not tell it yet: until then `known` holds.
        """
        if self.learnt is not None:
            return self.learnt
        return self.known if self._span < LEAST_SILENCE else self._middle

    @property
    def grace(self) -> float:
        """The silence in seconds that is allowed before the typical interval is known: 15 or 90.

        The shorter one holds after several messages: they are a burst, or a robot died after them.
        """
        return _MAYBE_A_BURST if len(self.intervals) >= _FEW else UNMEASURED


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
    """Return True if no message came for three periods, at least 2.5 s."""
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
        """Return the rate with one more message at `now`, in monotonic seconds.

        After a silence, as by `is_silent`, the interval is not known again. The rate stays the same
        if `now` is not later than the last message.
        """
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
        """Return True if no message came for three intervals, and at least 2.5 s.

        False while the interval is not known.
        """
        return is_silent(self.heard, self.interval, now, None)
