"""What was heard in the last minute, in memory, bounded in time and bytes."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

SPAN = 60.0  # s that are kept
MOST_BYTES = 16_000_000  # of the messages, as objects of Python
_LARGEST = 1_000_000  # bytes of one that stands on when it is too old
_OBJECT = 60  # bytes of one, about, beside what it holds
_NUMBER = 32
_NUMBERS = (float, int, bool)
# topics whose messages are events: of all others the last one says how things stand
_EVENTS = ("/rosout", "/parameter_events", "/_action/feedback", "/archo_tui/journal")


class Heard(NamedTuple):
    """One message, as it was received."""

    time: int  # ns since the epoch, by this machine's clock
    topic: str  # fully qualified
    message: Any


class Later(NamedTuple):
    """A message that is made only when it is written."""

    make: Callable[[bool], Any]  # called with True for the first of its topic in a recording
    weight: int  # bytes of memory, about


Listener = Callable[[Heard, int], None]  # a message, and its weight


def weight(value: Any) -> int:
    """About how many bytes of memory a message, or a part of one, takes."""
    if isinstance(value, Later):
        return value.weight
    if isinstance(value, (int, float)):
        return _NUMBER
    if isinstance(value, (str, bytes)):
        return _OBJECT + len(value)
    slots = getattr(type(value), "__slots__", ())
    if slots:
        whole = _OBJECT
        for slot in slots:
            part: Any = getattr(value, slot, None)
            kind = type(part)  # a call less for most
            if kind is str:
                whole += _OBJECT + len(part)
            else:
                whole += _NUMBER if kind in _NUMBERS else weight(part)
        return whole
    if isinstance(value, (list, tuple, set)):
        return _OBJECT + sum(map(weight, value))
    size = getattr(value, "nbytes", None)  # of an array, or a buffer of numpy's
    if size is None and hasattr(value, "itemsize"):
        size = len(value) * value.itemsize
    return _OBJECT + (size or 0)


class Ring:
    """Any thread adds, any thread copies."""

    def __init__(self, span: float = SPAN, most_bytes: int = MOST_BYTES) -> None:
        self._span, self._most = span, most_bytes
        self._lock = threading.Lock()
        self._kept: deque[tuple[Heard, float, int]] = deque()  # when it was added, its weight
        self._bytes = 0
        self._latched: dict[str, Heard] = {}  # the last of a topic that is too old to be kept
        self._also: list[Listener] = []

    def add(self, heard: Heard, now: float) -> None:
        """Keep it, since `now` (monotonic s); the oldest go that are too old, or too many."""
        size = weight(heard.message)
        with self._lock:
            self._kept.append((heard, now, size))
            self._bytes += size
            oldest = now - self._span
            while self._bytes > self._most or (self._kept and self._kept[0][1] < oldest):
                out, _, its_size = self._kept.popleft()
                self._bytes -= its_size
                if its_size <= _LARGEST and not out.topic.endswith(_EVENTS):
                    self._latched[out.topic] = out
            for listener in self._also:
                listener(heard, size)

    def copy_to(self, listener: Listener) -> Sequence[Heard]:
        """All that is kept, behind the last older one of each topic; `listener` gets what follows.

        It is called on the thread that adds, and must not wait.
        """
        with self._lock:
            self._also.append(listener)
            kept = [heard for heard, _, _ in self._kept]
            stands = [*self._latched.values()]
            if kept:
                stands = [heard._replace(time=kept[0].time) for heard in stands]
            return [*stands, *kept]

    def leave(self, listener: Listener) -> None:
        """It gets no more."""
        with self._lock:
            self._also.remove(listener)

    @property
    def bytes(self) -> int:
        """What is kept, about."""
        return self._bytes
