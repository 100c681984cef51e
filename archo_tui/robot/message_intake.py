"""The messages of an inspected topic between their arrival and their decoding.

All are counted, some are kept: however many come, and however large they are, at most some thirty a
second wait to be decoded.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

from archo_tui.robot.inspection import MAX_BYTES
from archo_tui.robot.message_rate import RATE_INTERVALS

_INTERVAL = 0.04  # Seconds between two kept messages; with the newest of each look, 30 a second.
_WAITING_BYTES = 16_000_000  # Of all messages that wait.
_WINDOW = 5.0  # Seconds in which the rate is measured.
_BUCKETS_PER_SECOND = 2


class RawMessage(NamedTuple):
    """A serialized message and the time of its arrival in seconds."""

    time: float
    data: bytes


class _Bucket(NamedTuple):
    """The messages that came within half a second.

    Attributes:
        number: The number of the half second, counted from the time 0.0.
        first: When the first message came, in seconds.
        messages: The number of messages that came.
        size: The bytes of all of them.
    """

    number: int
    first: float
    messages: int
    size: int


class MessageIntake:
    """A buffer of the messages of one topic, which one thread fills and another one drains.

    Attributes:
        received: The number of messages that came.
        last: When the last message came that was not kept for a new subscription, in seconds; None
            before the first.
        last_size: The bytes of the last message; 0 before the first.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()  # Held for no longer than an append takes.
        self.received = 0
        self.last: float | None = None
        self.last_size = 0
        self._waiting: list[RawMessage] = []
        self._waiting_bytes = 0
        self._kept_at: float | None = None
        self._newest: RawMessage | None = None  # If it is not among those that wait.
        self._last_few: deque[tuple[float, int]] = deque(maxlen=RATE_INTERVALS + 1)
        self._buckets: deque[_Bucket] = deque(maxlen=int(_WINDOW * _BUCKETS_PER_SECOND) + 1)

    def add(self, time: float, data: bytes, was_kept: bool = False) -> None:
        """Count a message, and keep it for `drain`, unless it is too large or too many wait.

        The newest message is always kept, unless it is larger than MAX_BYTES. Of the others, one
        each 40 ms is kept, up to 16 MB.

        Args:
            time: When it came, in seconds.
            data: The serialized message.
            was_kept: True if it was sent before: then it tells nothing of rate and age.
        """
        with self._lock:
            if not was_kept:
                self._count(time, len(data))
                self._last_few.append((time, len(data)))
                self.last = time
            self.received, self.last_size = self.received + 1, len(data)
            self._newest = None
            if len(data) > MAX_BYTES:
                return
            message = RawMessage(time, data)
            is_due = self._kept_at is None or not 0 <= time - self._kept_at < _INTERVAL
            if is_due and self._waiting_bytes + len(data) <= _WAITING_BYTES:
                self._waiting.append(message)
                self._waiting_bytes += len(data)
                self._kept_at = time
            else:
                self._newest = message

    def drain(self) -> list[RawMessage]:
        """Remove and return the messages that wait, the newest last."""
        with self._lock:
            found = [*self._waiting, *([] if self._newest is None else [self._newest])]
            self._waiting.clear()
            self._waiting_bytes, self._newest = 0, None
        return found

    @property
    def is_too_large(self) -> bool:
        """True if the last message is larger than MAX_BYTES, and so is not decoded."""
        return self.last_size > MAX_BYTES

    def rates(self, now: float) -> tuple[float, float] | None:
        """Return the mean rates in messages and in bytes a second, over the last 5 s or so.

        Of a slow topic the last three intervals count. A silence since the last message does not
        lower the rates.

        Args:
            now: The present time in seconds.

        Returns:
            The two rates; None before three intervals, and after a silence.
        """
        with self._lock:
            buckets, last, few = tuple(self._buckets), self.last, tuple(self._last_few)
        if last is None or len(few) <= RATE_INTERVALS:
            return None
        recent = [bucket for bucket in buckets if now - bucket.first <= _WINDOW]
        count, begin = sum(bucket.messages for bucket in recent), few[0][0]
        size = sum(bucket.size for bucket in recent)
        if count > RATE_INTERVALS:
            begin = recent[0].first
        elif now - last <= max(last - begin, _WINDOW):
            count, size = len(few), sum(size for _, size in few)
        else:
            return None
        if last <= begin:
            return None
        rate = (count - 1) / (last - begin)
        return rate, rate * size / count

    def _count(self, time: float, size: int) -> None:
        number = int(time * _BUCKETS_PER_SECOND)
        last = self._buckets[-1] if self._buckets else None
        if last is not None and last.number == number:
            messages = last.messages + 1
            self._buckets[-1] = last._replace(messages=messages, size=last.size + size)
        else:
            self._buckets.append(_Bucket(number, time, 1, size))
