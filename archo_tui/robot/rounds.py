"""Which parameters are read again, and when: all of them in a round, some at each look. Pure.

Nodes tell of their changes; but what they tell while a network comes or goes can be lost.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping

PERIOD = 30.0  # s from the beginning of a round to the next
SLICE = 200  # parameters that are asked for at once
MOST = 5  # questions at a look, one a second: beyond 150 slices a round takes longer


class Rounds:
    """Hands out the next slices of the round."""

    def __init__(self) -> None:
        self._left: deque[tuple[str, list[str]]] = deque()
        self._next = 0.0
        self._each = 0

    def due(self, now: float, names: Mapping[str, Iterable[str]]) -> list[tuple[str, list[str]]]:
        """Nodes, each with names of its parameters, that are to be read now (s)."""
        if not self._left:
            if now < self._next:
                return []
            self._next = now + PERIOD
            for node in sorted(names):
                known = list(names[node])
                slices = range(0, len(known), SLICE)
                self._left.extend((node, known[first : first + SLICE]) for first in slices)
            self._each = min(MOST, 1 + int(len(self._left) / PERIOD))
        return [self._left.popleft() for _ in range(min(self._each, len(self._left)))]
