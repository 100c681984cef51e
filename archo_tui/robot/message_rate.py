"""The present rate at which messages of a topic or a node come."""

from __future__ import annotations

from typing import NamedTuple

from archo_tui.robot.period import is_silent

_SMOOTHING = 0.2  # Our choice: the weight of the newest interval in a rate.


class MessageRate(NamedTuple):
    """The present rate of messages, measured from the start again after a silence.

    Attributes:
        heard: When the last message came, in monotonic seconds.
        interval: The smoothed interval in seconds; None before two messages.
    """

    heard: float
    interval: float | None = None

    def with_message_at(self, now: float) -> MessageRate:
        """Return the rate with one more message at `now`, in monotonic seconds."""
        if self.is_silent(now):
            return MessageRate(now)
        since = now - self.heard
        if since <= 0:
            return self
        before = since if self.interval is None else self.interval
        return MessageRate(now, before + _SMOOTHING * (since - before))

    @property
    def hertz(self) -> float | None:
        """The rate in Hz; None before two messages."""
        return 1 / self.interval if self.interval else None

    def is_silent(self, now: float) -> bool:
        """Return True after a silence of three intervals, at least 2.5 s, if two messages came."""
        return is_silent(self.heard, self.interval, now, None)
