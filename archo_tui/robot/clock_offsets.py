"""The offsets of other computers' clocks from this one's, by the stamps of what they send."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from typing import Any

LARGEST = 1.0  # Seconds; a larger offset is reported.
_COMPARED = 3  # Stamps; the one that fits best counts, since a message may be late.


class ClockOffsets:
    """The offset of each source of stamps. No input or output.

    Attributes:
        large: The sources whose offset is larger than LARGEST: their clock minus ours, in seconds.
    """

    def __init__(self) -> None:
        """Begin without a source."""
        self.large: Mapping[str, float] = {}
        self._offsets: dict[str, deque[float]] = {}

    def add(self, source: str, stamp: Any, now: float) -> bool:
        """Compare a stamp with the time at which it came.

        Args:
            source: A node, or a topic.
            stamp: A builtin_interfaces Time; one of zero is no stamp.
            now: Unix time by this computer's clock.

        Returns:
            True if `large` differs from before by a source, or by a second and more.
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
        """Forget sources that are not there any more, or whose stamps are of no clock."""
        self.large = {name: offset for name, offset in self.large.items() if name not in sources}
        for source in sources:
            self._offsets.pop(source, None)
