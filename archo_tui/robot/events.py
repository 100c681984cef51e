"""The log of the session: bounded, in order, repeats counted instead of repeated."""

from __future__ import annotations

import re
from dataclasses import replace

from archo_tui.robot.state import Event

LIMIT = 1000  # events kept
_OPERATORS = 200  # of them the operator's own, which a flood of others does not push out
_IN_PLACE = 30  # a repeat of one of that many newest events does not move it

_NUMBER = re.compile(r"\d+(\.\d+)?")
# C0 and C1 controls, and the marks that turn the direction of text around
_UNSAFE = re.compile("[\x00-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2060-\u2069\ufeff]")
_LONGEST = 500  # characters of a line that are kept


def harmless(text: str) -> str:
    """Text from outside without anything that a terminal could act on, and of bounded length."""
    text = _UNSAFE.sub("\N{REPLACEMENT CHARACTER}", text[: _LONGEST + 1])
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."


class EventLog:
    """Collects events; one that repeats another but for its numbers replaces it."""

    def __init__(self) -> None:
        self._events: dict[object, Event] = {}  # in their order; the key is what repeats have
        self._added: dict[object, int] = {}  # when each came to its place
        self._count = 0

    def add(self, event: Event) -> Event:
        """Append an event, or count it on the one it repeats. The operator's are never merged.

        Returns it as it stands in the log.
        """
        event = replace(event, text=harmless(event.text), source=harmless(event.source))
        key: object = (event.level, event.source, _NUMBER.sub("#", event.text))
        if event.level == "YOU":
            key = ("YOU", self._count)
        known = self._events.get(key)
        if known is not None:
            event = replace(event, count=known.count + 1)
            if self._count - self._added[key] >= _IN_PLACE:  # out of sight: it is news again
                del self._events[key]
                known = None
        if known is None:
            self._count += 1
            self._added[key] = self._count
        self._events[key] = event
        if len(self._events) > LIMIT:
            self._drop_oldest()
        return event

    def _drop_oldest(self) -> None:
        own = [key for key, event in self._events.items() if event.level == "YOU"]
        if len(own) > _OPERATORS:
            oldest: object = own[0]
        else:
            oldest = next(key for key, event in self._events.items() if event.level != "YOU")
        del self._events[oldest], self._added[oldest]

    def all(self) -> tuple[Event, ...]:
        """Oldest first."""
        return tuple(self._events.values())
