"""The inspection of one topic: how often its messages come, their size, and the last one."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message

from archo_tui.base.clock import Clock
from archo_tui.base.errors import ArchoError, in_one_line
from archo_tui.robot.graph.endpoints import DEPTH, fitting_qos
from archo_tui.robot.messages.period import RATE_INTERVALS
from archo_tui.robot.node import ConsoleNode
from archo_tui.robot.state.graph import TopicInfo
from archo_tui.robot.topics.rows import (
    FieldView,
    TopicFields,
    TopicRequest,
    TopicView,
    with_elements,
)
from archo_tui.robot_file.check import not_installed
from archo_tui.ros.names import package_of

# Seconds after a subscription in which a latched topic's messages are those that were kept for it.
_KEPT = 0.5
MAX_BYTES = 8_000_000  # Of a message that is decoded; with many small parts it takes seconds.
_INTERVAL = 0.04  # Seconds between two kept messages; with the newest of each look, 30 a second.
_WAITING_BYTES = 16_000_000  # Of all messages that wait.
_WINDOW = 5.0  # Seconds in which the rate is measured.
_COUNTED = 5_000  # Messages that count for the rate at most.


class Inspection:
    """A count of the messages of one topic, which lasts from `subscribe` to `unsubscribe`."""

    def __init__(
        self,
        node: ConsoleNode,
        clock: Clock,
        topic: str,
        message_class: Any,
        on_data: Callable[[float, bytes, bool], None] = lambda *_: None,
        depth: int = DEPTH,
    ) -> None:
        self._on_data, self._depth = on_data, depth
        self._node, self._clock, self._class = node, clock, message_class
        self._subscription: Any = None
        self._qos: QoSProfile | None = None
        # The last message: its number, counted from 1, and its bytes; (0, b"") before the first.
        self.newest: tuple[int, bytes] = (0, b"")
        self.topic = topic
        self.count = self.size = 0  # Of all messages that came, and their bytes.
        # Of those that were sent before and came because they were kept: they tell no rate.
        self.kept = self.kept_size = 0
        self._kept_until = -math.inf
        self.first = self.last = 0.0  # When messages came that were not kept; monotonic, s.
        self.least: float | None = None  # The shortest time between two messages, in seconds.
        self.greatest: float | None = None  # The longest time between two messages, in seconds.

    def subscribe(self) -> None:
        """Begin to count, with a QoS that fits the present publishers. ROS thread only."""
        publishers = self._node.get_publishers_info_by_topic(self.topic)
        self._qos = fitting_qos(publishers, self._depth)
        if self._qos.durability == DurabilityPolicy.TRANSIENT_LOCAL:
            self._kept_until = self._clock.monotonic() + _KEPT
        self._subscription = self._node.listen_raw(self._class, self.topic, self._take, self._qos)

    def resubscribe_if_needed(self) -> None:
        """Subscribe again if the QoS fits the publishers no more; ROS thread only."""
        publishers = self._node.get_publishers_info_by_topic(self.topic)
        if self._subscription is None or not publishers:
            return
        if fitting_qos(publishers, self._depth) == self._qos:
            return
        self.unsubscribe()
        self.subscribe()

    def unsubscribe(self) -> None:
        """End the subscription, if there is one; the counts stay. ROS thread only."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _take(self, data: bytes) -> None:
        now = self._clock.monotonic()
        was_kept = now < self._kept_until
        if was_kept:
            self.kept, self.kept_size = self.kept + 1, self.kept_size + len(data)
        elif self.count == self.kept:
            self.first = self.last = now
        else:
            interval = now - self.last
            self.least = interval if self.least is None else min(self.least, interval)
            self.greatest = interval if self.greatest is None else max(self.greatest, interval)
            self.last = now
        self.size += len(data)
        self.newest = self.count + 1, data
        self.count += 1  # Last: another thread that reads it finds the rest set.
        self._on_data(now, data, was_kept)

    @property
    def rate(self) -> float | None:
        """The mean rate in Hz from the first message to the last; None before three intervals."""
        span, intervals = self.last - self.first, self.count - self.kept - 1
        return intervals / span if span > 0 and intervals >= RATE_INTERVALS else None

    def decode(self, data: bytes) -> Any:
        """Return the message in serialized bytes, secrets masked; else raise ArchoError."""
        if len(data) > MAX_BYTES:
            raise ArchoError(too_large(len(data)))
        try:
            return self._node.without_secrets(deserialize_message(data, self._class))
        except Exception as error:  # rclpy raises several types for bytes of another definition.
            why = f"not readable, its publisher may have another definition: {in_one_line(error)}"
            raise ArchoError(why) from None


def too_large(size: int) -> str:
    """Return the line that says why a message of so many bytes is not shown."""
    return f"not shown: a message of {size / 1e6:.1f} MB, more than {MAX_BYTES / 1e6:g} MB"


class RawMessage(NamedTuple):
    """A serialized message and the time of its arrival in seconds."""

    time: float
    data: bytes


class MessageIntake:
    """A buffer of the messages of one topic, which one thread fills and another one drains."""

    def __init__(self) -> None:
        self._lock = threading.Lock()  # Held for no longer than an append takes.
        self.received = 0  # The number of messages that came.
        # When the last message came that was not kept for a new subscription, in seconds; None
        # before the first.
        self.last: float | None = None
        self.last_size = 0  # The bytes of the last message; 0 before the first.
        self._waiting: list[RawMessage] = []
        self._waiting_bytes = 0
        self._kept_at: float | None = None
        self._newest: RawMessage | None = None  # If it is not among those that wait.
        self._arrivals: deque[tuple[float, int]] = deque(maxlen=_COUNTED)  # Times and bytes.

    def add(self, time: float, data: bytes, was_kept: bool = False) -> None:
        """Count a message, and keep the newest, and one each 40 ms up to 16 MB, for `drain`."""
        with self._lock:
            if not was_kept:
                self._arrivals.append((time, len(data)))
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
        """Return the mean messages and bytes a second over 5 s, at least three intervals."""
        with self._lock:
            arrivals = tuple(self._arrivals)
        counted = [arrival for arrival in arrivals if now - arrival[0] <= _WINDOW]
        if len(counted) <= RATE_INTERVALS:
            counted = [*arrivals[-RATE_INTERVALS - 1 :]]
            if len(counted) <= RATE_INTERVALS:
                return None
            if now - counted[-1][0] > max(counted[-1][0] - counted[0][0], _WINDOW):
                return None
        span = counted[-1][0] - counted[0][0]
        if span <= 0:
            return None
        rate = (len(counted) - 1) / span
        return rate, rate * sum(size for _, size in counted) / len(counted)


PERIOD = 0.2  # Seconds between two views.
SHARE = 0.2  # The share of a processor's time that decoding takes at most.


class TopicWatch:
    """The conversion of one topic's messages into views, live and in a replay."""

    def __init__(
        self,
        topic: str,
        kind: str,
        units: Mapping[str, str],
        intake: MessageIntake,
        decode: Callable[[bytes], Any],
    ) -> None:
        self._topic, self._kind = topic, kind
        self._intake, self._decode = intake, decode
        self._fields = TopicFields(units)
        self._fault = ""  # Why the last message could not be decoded.

    def update(self, now: float, request: TopicRequest, *, only_newest: bool = False) -> TopicView:
        """Decode the messages that have come since the last call, and return a view."""
        waiting = self._intake.drain()
        for message in waiting[-1:] if only_newest else waiting:
            try:
                self._fields.add(message.time, self._decode(message.data), request.open_arrays)
                self._fault = ""
            except ArchoError as error:
                self._fault = str(error)
            except Exception as error:  # A hostile message may raise anything.
                self._fault = f"not shown: {in_one_line(error)}"
        fields: tuple[FieldView, ...] = ()
        try:
            fields = self._fields.rows(now, request)
        except Exception as error:  # As above.
            self._fault = f"not shown: {in_one_line(error)}"
        rates, last = self._intake.rates(now), self._intake.last
        message = self._fields.message
        is_too_large = self._intake.is_too_large
        return TopicView(
            self._topic,
            self._kind,
            received=self._intake.received,
            rate=rates and rates[0],
            bytes_per_second=rates and rates[1],
            age=None if last is None else max(now - last, 0.0),
            fields=fields,
            is_cut=self._fields.is_cut,
            plots=self._fields.plots(now, request),
            open_arrays=request.open_arrays,
            with_elements=None if message is None else partial(with_elements, message),
            fault=too_large(self._intake.last_size) if is_too_large else self._fault,
        )


def types_of(ends: TopicInfo) -> list[str]:
    """Return the types of a topic's publishers, else of its subscriptions; sorted, each once."""
    return sorted({end.type for end in ends.publishers or ends.subscriptions})


def missing_type(topic: str, kind: str) -> str:
    """Return a text that a topic's type is not installed, and how to install it."""
    return f"{not_installed(topic, kind)}: install its package {package_of(kind)}, and restart"


def publisher_fault(ends: TopicInfo, kind: str) -> str:
    """Return what is wrong with the publishers of a topic that is shown as a type, or ""."""
    if not ends.publishers:
        return "it has no publisher: waiting for one"
    others = [other for other in types_of(ends) if other != kind]
    return f"also published as {', '.join(others)}, which is not shown" if others else ""
