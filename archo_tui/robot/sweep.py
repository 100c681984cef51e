"""Things that are asked for again and again: the urgent ones first, each within PERIOD. Pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Collection, Iterable, Iterator
from collections.abc import Set as AbstractSet
from typing import Generic, TypeVar

T = TypeVar("T")

PERIOD = 30  # looks, one a second, in which each thing is asked for at least once
LEAST = 10  # things that are asked for at each look: with fewer, all of them every second


class Sweep(Generic[T]):
    """Hands out the things that are due; whoever takes them stops when the time is up."""

    def __init__(self) -> None:
        self._urgent: OrderedDict[T, None] = OrderedDict()
        self._in_turn: OrderedDict[T, None] = OrderedDict()  # the one that waits longest is first

    def follow(self, things: AbstractSet[T]) -> None:
        """Take in new things, which are urgent, and drop those that are not there any more."""
        for gone in self._in_turn.keys() - things:
            del self._in_turn[gone]
            self._urgent.pop(gone, None)
        new = things - self._in_turn.keys()
        self._in_turn.update(dict.fromkeys(new))
        self.hurry(new)

    def hurry(self, things: Iterable[T]) -> None:
        """Make things urgent that are followed already."""
        self._urgent.update(dict.fromkeys(things))

    def due(self) -> Iterator[T]:
        """Yield what is urgent, then as many of the rest as keep to PERIOD.

        What is made urgent meanwhile comes at the next call.
        """
        urgent: Collection[T] = tuple(self._urgent)
        for thing in urgent:
            del self._urgent[thing]
            self._in_turn.move_to_end(thing)
            yield thing
        share = max(LEAST, -(-len(self._in_turn) // PERIOD)) - len(urgent)
        for _ in range(min(share, len(self._in_turn))):
            thing = next(iter(self._in_turn))
            self._in_turn.move_to_end(thing)
            yield thing
