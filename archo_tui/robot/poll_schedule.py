"""A schedule of questions that are asked again and again. No input or output."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Collection, Iterable, Iterator
from collections.abc import Set as AbstractSet
from typing import Generic, TypeVar

T = TypeVar("T")

PERIOD = 30  # Each item is due at least once in so many polls, of which there is one a second.
LEAST = 10  # Items that are due at each poll, so that few items are all due each time.


class PollSchedule(Generic[T]):
    """A queue of items to poll: urgent ones first, then those that have waited longest."""

    def __init__(self) -> None:
        self._urgent: OrderedDict[T, None] = OrderedDict()
        self._in_turn: OrderedDict[T, None] = OrderedDict()  # The longest wait comes first.

    def set_items(self, items: AbstractSet[T]) -> None:
        """Replace the set of items: new ones become urgent, and missing ones are dropped."""
        for gone in self._in_turn.keys() - items:
            del self._in_turn[gone]
            self._urgent.pop(gone, None)
        new = items - self._in_turn.keys()
        self._in_turn.update(dict.fromkeys(new))
        self.prioritize(new)

    def prioritize(self, items: Iterable[T]) -> None:
        """Make items urgent for the next poll; they must be among those that were set."""
        self._urgent.update(dict.fromkeys(items))

    def take_due(self) -> Iterator[T]:
        """Yield the items for this poll: all urgent ones, then the longest waiting up to a share.

        The share is a thirtieth of all items, at least ten, less the urgent ones. A yielded item
        counts as polled.
        """
        urgent: Collection[T] = tuple(self._urgent)
        for item in urgent:
            del self._urgent[item]
            self._in_turn.move_to_end(item)
            yield item
        share = max(LEAST, -(-len(self._in_turn) // PERIOD)) - len(urgent)
        for _ in range(min(share, len(self._in_turn))):
            item = next(iter(self._in_turn))
            self._in_turn.move_to_end(item)
            yield item
