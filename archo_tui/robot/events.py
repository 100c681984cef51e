"""The log of the session: bounded, in order, repeats counted instead of repeated."""

from __future__ import annotations

import re
from collections import OrderedDict
from dataclasses import replace

from archo_tui.robot.state import OWN_LEVELS, Event
from archo_tui.robot.text import harmless

LIMIT = 1000  # events kept
_OWN = 200  # of them the console's own, which a flood of others does not push out

_NUMBER = re.compile(r"\d+(\.\d+)?")


class EventLog:
    """Collects events; one that repeats another but for its numbers replaces it."""

    def __init__(self) -> None:
        self._count = 0
        # by what repeats have in common; each with its place among all of them
        self._own: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._others: OrderedDict[object, tuple[int, Event]] = OrderedDict()

    def add(self, event: Event) -> Event:
        """Append an event, or count it on the one it repeats. The console's own are never merged.

        Returns it as it stands in the log.
        """
        self._count += 1
        event = replace(
            event,
            text=harmless(event.text),
            source=harmless(event.source),
            first=event.time,
            number=self._count,
        )
        if event.level in OWN_LEVELS:
            return self._keep(self._own, _OWN, self._count, event)
        key = (event.level, event.source, _NUMBER.sub("#", event.text))
        return self._keep(self._others, LIMIT - _OWN, key, event)

    def _keep(
        self, kept: OrderedDict[object, tuple[int, Event]], limit: int, key: object, event: Event
    ) -> Event:
        if key in kept:
            _, known = kept.pop(key)
            event = replace(event, count=known.count + 1, first=known.first, number=known.number)
        kept[key] = self._count, event
        if len(kept) > limit:
            kept.popitem(last=False)
        return event

    def all(self) -> tuple[Event, ...]:
        """Oldest first."""
        places = (*self._own.values(), *self._others.values())
        return tuple(event for _, event in sorted(places, key=lambda kept: kept[0]))
