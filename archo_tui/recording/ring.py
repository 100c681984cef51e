"""The messages of the last minute in memory, bounded in time and bytes."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

SPAN = 60.0  # Seconds.
MAX_BYTES = 16_000_000  # Memory of all messages, as Python objects.
_MAX_LATCHED = 1_000_000  # Bytes of a message that is kept beyond its time.
_OBJECT_BYTES = 60  # Measured: a Python object without its content.
_NUMBER_BYTES = 32
_NUMBER_TYPES = (float, int, bool)
# The topics whose messages are events; of all others the last message is the current state.
_EVENT_TOPICS = ("/rosout", "/parameter_events", "/_action/feedback", "/archo_tui/journal")


class ReceivedMessage(NamedTuple):
    """A message, or the LazyMessage that makes it, with the time and topic of its receiving."""

    time: int  # In ns, monotonic: the writer of a bag makes Unix times of them.
    topic: str  # With its namespace.
    message: Any


class LazyMessage(NamedTuple):
    """A message that is built only if it is written.

    Attributes:
        make: Builds the message; called on the writing thread, with True until a message of its
            topic is in the bag, and with Unix time minus monotonic time, in s.
        weight: The memory that it takes while it waits, in bytes, approximately.
    """

    make: Callable[[bool, float], Any]
    weight: int


Listener = Callable[[ReceivedMessage, int], None]  # Gets a message and its weight.


def weight(value: Any) -> int:
    """Return the memory that a message or a part of one takes, in bytes, approximately."""
    if isinstance(value, LazyMessage):
        return value.weight
    if isinstance(value, (int, float)):
        return _NUMBER_BYTES
    if isinstance(value, (str, bytes)):
        return _OBJECT_BYTES + len(value)
    slots = getattr(type(value), "__slots__", ())
    if slots:
        whole = _OBJECT_BYTES
        for slot in slots:
            part: Any = getattr(value, slot, None)
            kind = type(part)  # Spares most parts a call of this function.
            if kind is str:
                whole += _OBJECT_BYTES + len(part)
            else:
                whole += _NUMBER_BYTES if kind in _NUMBER_TYPES else weight(part)
        return whole
    if isinstance(value, (list, tuple, set)):
        return _OBJECT_BYTES + sum(map(weight, value))
    size = getattr(value, "nbytes", None)  # An array.array or a numpy array.
    if size is None and hasattr(value, "itemsize"):
        size = len(value) * value.itemsize
    return _OBJECT_BYTES + (size or 0)


class Ring:
    """A buffer of the last minute of messages, at most 16 MB of them. Thread-safe.

    The last message of each topic is kept beyond its time, unless it is larger than 1 MB or tells
    an event, as those of `/rosout` do: it shows the state of things at the beginning of a
    recording.
    """

    def __init__(self, span: float = SPAN, max_bytes: int = MAX_BYTES) -> None:
        self._span, self._max_bytes = span, max_bytes
        self._lock = threading.Lock()
        # Each with the monotonic time at which it was added, and its weight.
        self._messages: deque[tuple[ReceivedMessage, float, int]] = deque()
        self._bytes = 0
        # The last message of each topic that has become too old for the deque.
        self._latched: dict[str, ReceivedMessage] = {}
        self._listeners: list[Listener] = []

    def add(self, received: ReceivedMessage, now: float) -> None:
        """Keep a message, drop the oldest beyond the time or the bytes, and call the listeners.

        The listeners get the message though it may be too large to be kept.

        Args:
            received: The message.
            now: Monotonic time, in s.
        """
        size = weight(received.message)
        with self._lock:
            self._messages.append((received, now, size))
            self._bytes += size
            cutoff = now - self._span
            while self._bytes > self._max_bytes or (
                self._messages and self._messages[0][1] < cutoff
            ):
                oldest, _, oldest_size = self._messages.popleft()
                self._bytes -= oldest_size
                if oldest_size <= _MAX_LATCHED and not oldest.topic.endswith(_EVENT_TOPICS):
                    self._latched[oldest.topic] = oldest
            for listener in self._listeners:
                listener(received, size)

    def subscribe(self, listener: Listener) -> Sequence[ReceivedMessage]:
        """Return the messages kept so far, and pass all that follow to `listener`.

        The last messages of topics that have been silent for longer come first, with the time of
        the oldest other message, if there is one.

        Args:
            listener: Called with a message and its weight on the thread that adds it, under the
                ring's lock: it must not wait.
        """
        with self._lock:
            self._listeners.append(listener)
            kept = [message for message, _, _ in self._messages]
            latched = [*self._latched.values()]
            if kept:
                latched = [message._replace(time=kept[0].time) for message in latched]
            return [*latched, *kept]

    def unsubscribe(self, listener: Listener) -> None:
        """Pass no further messages to `listener`; raise ValueError if it is not subscribed."""
        with self._lock:
            self._listeners.remove(listener)

    @property
    def bytes(self) -> int:
        """Return the memory that the messages of the last minute take, in bytes, approximately."""
        return self._bytes
