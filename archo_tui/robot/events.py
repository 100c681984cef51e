"""The log of the session: bounded, in order, repeats counted instead of repeated."""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Iterable
from operator import itemgetter

from archo_tui.robot.state import OWN_LEVELS, Event
from archo_tui.robot.text import harmless

LIMIT = 1000  # events kept
_OWN = 200  # of them the console's own, which a flood of others does not push out

_NUMBER = re.compile(r"\d+(\.\d+)?")


def _common(level: str, source: str, text: str) -> object:
    """What an event has in common with those that repeat it."""
    return level, source, _NUMBER.sub("#", text)


class EventLog:
    """Collects events; one that repeats another but for its numbers replaces it."""

    def __init__(self) -> None:
        self._count = 0
        # by what repeats have in common; each with its place among all of them
        self._own: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._others: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._all: tuple[Event, ...] | None = ()  # None: not put in order yet

    def add(self, event: Event) -> Event:
        """Append an event, or count it on the one it repeats. The console's own are never merged.

        Returns it as it stands in the log.
        """
        self._count += 1
        self._all = None
        text, source = harmless(event.text), harmless(event.source)
        kept, limit, key = self._others, LIMIT - _OWN, _common(event.level, source, text)
        if event.level in OWN_LEVELS:
            kept, limit, key = self._own, _OWN, self._count
        known = kept.pop(key)[1] if key in kept else None
        event = Event(
            event.time,
            event.level,
            source,
            text,
            event.command,
            count=1 if known is None else known.count + 1,
            first=event.time if known is None else known.first,
            number=self._count if known is None else known.number,
            act=None if event.act is None else event.act.bounded(),
        )
        kept[key] = self._count, event
        if len(kept) > limit:
            kept.popitem(last=False)
        return event

    @classmethod
    def of(cls, events: Iterable[Event]) -> EventLog:
        """One that has these, oldest first."""
        log, events = cls(), tuple(events)
        for log._count, event in enumerate(events, 1):
            if event.level in OWN_LEVELS:
                log._own[log._count] = log._count, event
            else:
                key = _common(event.level, event.source, event.text)
                log._others[key] = log._count, event
        log._count = max(
            log._count, *(event.number for event in events), 0
        )  # further on from there
        log._all = None
        return log

    def copy(self) -> EventLog:
        """Another one with the same events."""
        log = EventLog()
        log._count, log._own, log._others = self._count, self._own.copy(), self._others.copy()
        log._all = self._all
        return log

    def all(self) -> tuple[Event, ...]:
        """Oldest first; the same object until one is added."""
        if self._all is None:
            places = (*self._own.values(), *self._others.values())
            self._all = tuple(event for _, event in sorted(places, key=itemgetter(0)))
        return self._all
