"""The clocks of other computers, as far as they differ. No input or output."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from typing import Any

LARGEST = 1.0  # Seconds; a larger offset is reported.
_COMPARED = 3  # Stamps; the one that fits best counts, since a message may be late.


class ClockOffsets:
    """The offset between the clock of each source of stamps, a node or a topic, and this one's."""

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
