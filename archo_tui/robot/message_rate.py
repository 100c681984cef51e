"""The rate at which messages of a topic or a node come at present."""

from __future__ import annotations

from typing import NamedTuple

from archo_tui.robot.period import is_silent

RATE_INTERVALS = 3  # Fewer intervals tell no rate.
_SMOOTHING = 0.2  # Our choice: the weight of the newest interval in a rate.


class MessageRate(NamedTuple):
    """The present rate of messages; immutable. After a silence it is measured anew."""

    heard: float  # When the last message came, in monotonic seconds.
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
