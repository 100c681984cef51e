"""Nodes that come and leave, as lines for the events. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable

SETTLED = 5.0  # s without a new node, after which all that was there at the start is found
NAMED = 3  # nodes that are named in one line; of more the others are counted
_LINES, _SPAN = 5, 20.0  # lines in so many s; what comes then waits, and is told together


class Arrivals:
    """Compares the nodes of each look at the graph with those of the look before.

    Nodes that come while the first picture forms are not told of, nor those that this process
    hosts: what becomes of these is told by whoever starts and stops them.
    """

    def __init__(self, now: float) -> None:
        """Begin the first picture at `now`, in monotonic s."""
        self._known: set[str] = set()
        self._own: set[str] = set()  # of this process, those of before too
        self._settles = now + SETTLED
        self._came: list[str] = []  # not told of yet
        self._left: list[str] = []
        self._told: deque[float] = deque(maxlen=_LINES)  # when the last lines were told

    def compare(self, names: Iterable[str], own: Collection[str], now: float) -> list[str]:
        """Return the lines that are due.

        Args:
            names: The full names of all nodes on the graph.
            own: Those of the nodes that this process hosts.
            now: Monotonic time in s.
        """
        found = set(names)
        self._own.update(own)
        came, left = found - self._known, self._known - found
        self._known = found
        if now < self._settles:
            if came:
                self._settles = now + SETTLED
            came = set()
        self._came += sorted(came - self._own)
        self._left += sorted(left - self._own)
        if len(self._told) == _LINES and now - self._told[0] < _SPAN:
            return []
        lines = [*_lines("left", self._left), *_lines("came", self._came)]
        self._came, self._left = [], []
        self._told.extend([now] * len(lines))
        return lines


def _lines(verb: str, names: Iterable[str]) -> list[str]:
    """Return a line for each node; of more than NAMED one line for all of them."""
    nodes = [name.lstrip("/") for name in dict.fromkeys(names)]
    if len(nodes) <= NAMED:
        return [f"node {name} {verb}" for name in nodes]
    more = len(nodes) - NAMED
    return [f"{len(nodes)} nodes {verb}: {', '.join(nodes[:NAMED])} and {more} more"]
