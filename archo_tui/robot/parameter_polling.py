"""The schedule by which the parameters of all nodes are read again. No input or output.

Nodes publish their changes on /parameter_events, but a message can be lost while a network comes or
goes. So all parameters are read again in each round, some at each poll of the graph.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping

PERIOD = 30.0  # Seconds from the beginning of a round to that of the next.
SLICE = 200  # Parameters in one request.
# Requests a poll, of which there is one a second. With more than 150 requests a round takes longer.
MAX_REQUESTS = 5


class ParameterPolling:
    """The schedule by which all parameters of all nodes are read again, in rounds of PERIOD."""

    def __init__(self) -> None:
        self._left: deque[tuple[str, list[str]]] = deque()  # Requests of this round.
        self._next = 0.0  # Monotonic seconds at which the next round may begin.
        self._each = 0  # Requests a poll in this round.

    def take_due(
        self, now: float, names: Mapping[str, Iterable[str]]
    ) -> list[tuple[str, list[str]]]:
        """Remove and return the requests for this poll; [] while the next round is not due.

        A round begins PERIOD after the last one began, or later if that is not done.
        """
        if not self._left:
            if now < self._next:
                return []
            self._next = now + PERIOD
            for node in sorted(names):
                known = list(names[node])
                slices = range(0, len(known), SLICE)
                self._left.extend((node, known[first : first + SLICE]) for first in slices)
            self._each = min(MAX_REQUESTS, 1 + int(len(self._left) / PERIOD))
        return [self._left.popleft() for _ in range(min(self._each, len(self._left)))]
