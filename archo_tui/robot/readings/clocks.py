"""The clocks that others go by: those of other computers, and simulated time on /clock."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Mapping
from typing import Any

from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock as ClockMessage

from archo_tui.clock import Clock
from archo_tui.robot.node import Listener

LARGEST = 1.0  # Seconds; a larger offset is reported.
_COMPARED = 3  # Stamps; the one that fits best counts, since a message may be late.


class ClockOffsets:
    """The offset between the clock of each source of stamps, a node or a topic, and this one's.

    No input or output.
    """

    def __init__(self) -> None:
        # The offsets larger than LARGEST, by source: its clock minus ours, in seconds.
        self.large: Mapping[str, float] = {}
        self._offsets: dict[str, deque[float]] = {}

    def add(self, source: str, stamp: Any, now: float) -> bool:
        """Compare a stamp with the time of its receipt, and update `large`.

        The smallest offset of the last three stamps counts, as a message may be late; the first two
        of a source change nothing.
        """
        if not (stamp.sec or stamp.nanosec):
            return False
        offsets = self._offsets.setdefault(source, deque(maxlen=_COMPARED))
        offsets.append(stamp.sec + stamp.nanosec * 1e-9 - now)
        offset = min(offsets, key=abs)
        known = self.large.get(source)
        if len(offsets) < _COMPARED or abs(offset) <= LARGEST:
            if known is not None:
                self.large = {name: o for name, o in self.large.items() if name != source}
            return known is not None
        if known is not None and abs(known - offset) < 1.0:
            return False
        self.large = {**self.large, source: offset}
        return True

    def forget(self, sources: Collection[str]) -> None:
        """Remove sources from `large`, and forget their stamps; unknown sources are ignored."""
        self.large = {name: offset for name, offset in self.large.items() if name not in sources}
        for source in sources:
            self._offsets.pop(source, None)


_PERIOD = 5.0  # Seconds between two looks: a simulator may send it a thousand times a second.


class SimClock:
    """The last looks at /clock, one message each."""

    def __init__(self, node: Listener, clock: Clock, on_change: Callable[[], None]) -> None:
        self._node, self._clock, self._on_change = node, clock, on_change
        self._subscription: Any = None  # While a look lasts.
        self._begun = -_PERIOD  # When the last look began.
        self._message = b""
        self._changed: float | None = None  # When the message was found first.
        # Monotonic time since when it shows the same time, or nothing is heard of it; None while it
        # goes on, or nothing needs it.
        self.still_since: float | None = None

    def poll(self, *, is_needed: bool) -> None:
        """Begin a look, if one is due. Call it each second."""
        now = self._clock.monotonic()
        if not is_needed:
            self._end_look()
            self._changed = None
            self._set_still(None)
            return
        self._changed = now if self._changed is None else self._changed
        if now - self._begun < _PERIOD:
            return
        if self._subscription is not None:  # Nothing has come.
            self._set_still(self._changed)
            return
        self._begun = now
        qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._subscription = self._node.listen_raw(ClockMessage, "/clock", self._take, qos)

    def _take(self, message: bytes) -> None:
        if self._subscription is None or self._changed is None:
            return
        if message != self._message:
            self._message, self._changed = message, self._clock.monotonic()
            self._set_still(None)
        else:
            self._set_still(self._changed)
        if self._node.executor is not None:  # A subscription must outlast its own callback.
            self._node.executor.create_task(self._end_look)

    def _set_still(self, since: float | None) -> None:
        if since != self.still_since:
            self.still_since = since
            self._on_change()

    def _end_look(self) -> None:
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
