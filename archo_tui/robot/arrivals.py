"""The lines for the log about nodes that come to the graph and leave it. No input or output."""

from __future__ import annotations

from collections.abc import Collection, Iterable

SETTLED = 5.0  # Seconds without a new node after which the graph counts as discovered.
NAMED = 3  # Nodes that one line names; it counts the others.


class Arrivals:
    """A comparison of the nodes at each poll of the graph with those at the poll before.

    No line is made for a node that comes while the graph is first discovered, nor for one that this
    process ever hosted: its host reports that node.
    """

    def __init__(self, now: float) -> None:
        self._known: set[str] = set()
        self._own: set[str] = set()
        self._settles = now + SETTLED

    def compare(self, names: Iterable[str], own: Collection[str], now: float) -> list[str]:
        """Return `node NAME left` and `node NAME came` for each that did since the last call."""
        found = set(names)
        self._own.update(own)
        came, left = found - self._known, self._known - found
        self._known = found
        if now < self._settles:
            self._settles = now + SETTLED if came else self._settles
            came = set()
        return [*_lines("left", left - self._own), *_lines("came", came - self._own)]


def _lines(verb: str, names: Collection[str]) -> list[str]:
    """Return a line for each node, or one for all if there are more than NAMED."""
    nodes = [name.lstrip("/") for name in sorted(names)]
    if len(nodes) <= NAMED:
        return [f"node {name} {verb}" for name in nodes]
    more = len(nodes) - NAMED
    return [f"{len(nodes)} nodes {verb}: {', '.join(nodes[:NAMED])} and {more} more"]
