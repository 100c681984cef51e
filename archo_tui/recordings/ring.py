"""The messages of the last minute in memory, bounded in time and bytes."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

SPAN = 60.0  # Seconds.
MAX_BYTES = 16_000_000
_MAX_LATCHED = 1_000_000  # Bytes of a message that is kept beyond its time.
_OBJECT_BYTES = 150  # Measured: a message without its content.
# The topics whose messages are events; of all others the last message is the current state.
_EVENT_TOPICS = ("/rosout", "/parameter_events", "/_action/feedback", "/archo_tui/journal")


class LazyMessage(NamedTuple):
    """A message of the console's own that is made only if it is written.

    `make` gets True until a message of its topic is in the bag, and Unix minus monotonic time.
    """

    make: Callable[[bool, float], Any]
    bytes: int  # That it takes while it waits, approximately.


class ReceivedMessage(NamedTuple):
    """A message as it was received."""

    time: int  # In ns, monotonic: the writer of a bag makes Unix times of them.
    topic: str  # With its namespace.
    message_class: Any
    content: bytes | LazyMessage  # CDR.

    @property
    def bytes(self) -> int:
        """The memory that it takes, approximately."""
        content = self.content
        return _OBJECT_BYTES + (len(content) if isinstance(content, bytes) else content.bytes)


Listener = Callable[[ReceivedMessage], None]


class Ring:
    """A buffer of the last minute of messages, at most 16 MB of them. Thread-safe.

    The last message of each topic is kept beyond its time, unless it is larger than 1 MB or tells
    an event, as those of `/rosout` do: it shows the state of things at the beginning of a
    recording.
    """

    def __init__(self, span: float = SPAN, max_bytes: int = MAX_BYTES) -> None:
        self._span, self._max_bytes = round(span * 1e9), max_bytes
        self._lock = threading.Lock()
        self._messages: deque[ReceivedMessage] = deque()
        self._bytes = 0
        # The last message of each topic that has become too old for the deque.
        self._latched: dict[str, ReceivedMessage] = {}
        self._listeners: list[Listener] = []

    def add(self, received: ReceivedMessage) -> None:
        """Keep a message, drop the oldest beyond the time or the bytes, and call the listeners.

        The listeners get the message though it may be too large to be kept.
        """
        with self._lock:
            self._messages.append(received)
            self._bytes += received.bytes
            cutoff = received.time - self._span
            while self._bytes > self._max_bytes or (
                self._messages and self._messages[0].time < cutoff
            ):
                oldest = self._messages.popleft()
                self._bytes -= oldest.bytes
                if oldest.bytes <= _MAX_LATCHED and not oldest.topic.endswith(_EVENT_TOPICS):
                    self._latched[oldest.topic] = oldest
            for listener in self._listeners:
                listener(received)

    def subscribe(self, listener: Listener) -> list[ReceivedMessage]:
        """Return the messages kept so far, and pass all that follow to `listener`, under the lock.

        The last messages of topics that have been silent for longer come first, with the time of
        the oldest other message, if there is one.
        """
        with self._lock:
            self._listeners.append(listener)
            latched = [*self._latched.values()]
            if self._messages:
                begin = self._messages[0].time
                latched = [message._replace(time=begin) for message in latched]
            return [*latched, *self._messages]

    def unsubscribe(self, listener: Listener) -> None:
        with self._lock:
            self._listeners.remove(listener)

    @property
    def bytes(self) -> int:
        """The memory that the messages of the last minute take, approximately."""
        return self._bytes
