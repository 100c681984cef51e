"""The lines for the log about nodes that come to the graph and leave it. No input or output."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable

SETTLED = 5.0  # Seconds without a new node after which the graph counts as discovered.
NAMED = 3  # Nodes that one line names; it counts the others.
_LINES, _SPAN = 5, 20.0  # At most so many lines in so many seconds; later nodes share a line.


class Arrivals:
    """A comparison of the nodes at each poll of the graph with those at the poll before.

    No line is made for a node that comes while the graph is first discovered (until no new node
    came for 5 s), nor for a node that this process hosts or hosted: its host reports that node.
    """

    def __init__(self, now: float) -> None:
        """Begin with no known node, and with the discovery of the graph.

        Args:
            now: Monotonic time in seconds.
        """
        self._known: set[str] = set()
        self._own: set[str] = set()  # All nodes that this process ever hosted.
        self._settles = now + SETTLED
        self._came: list[str] = []  # Nodes without a line yet, as in `_left`.
        self._left: list[str] = []
        self._line_times: deque[float] = deque(maxlen=_LINES)  # Monotonic seconds.

    def compare(self, names: Iterable[str], own: Collection[str], now: float) -> list[str]:
        """Return the lines that are due: `node NAME left`, then `node NAME came`.

        At most about five lines are returned in 20 s. Later nodes wait, and share a line in a later
        call. The names are remembered for the next call.

        Args:
            names: The full names of all nodes on the graph.
            own: The full names of the nodes that this process hosts.
            now: Monotonic time in seconds.
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
        if len(self._line_times) == _LINES and now - self._line_times[0] < _SPAN:
            return []
        lines = [*_lines("left", self._left), *_lines("came", self._came)]
        self._came, self._left = [], []
        self._line_times.extend([now] * len(lines))
        return lines


def _lines(verb: str, names: Iterable[str]) -> list[str]:
    """Return a line for each node, or one for all if there are more than NAMED.

    Args:
        verb: `came` or `left`.
        names: The full names; repeats are left out.
    """
    nodes = [name.lstrip("/") for name in dict.fromkeys(names)]
    if len(nodes) <= NAMED:
        return [f"node {name} {verb}" for name in nodes]
    more = len(nodes) - NAMED
    return [f"{len(nodes)} nodes {verb}: {', '.join(nodes[:NAMED])} and {more} more"]
