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
ROUTINE = ("DEBUG", "INFO")  # levels of what nodes log all the time; pushes out nothing worse
MOST_LINES = 50  # different lines of ROUTINE levels that are kept of a source in a second
_PERIOD = 1.0  # s: that second
LEFT_OUT = f"lines were left out: more than {MOST_LINES} in a second"

# With a point a number is a reading, which drifts: `Low battery: 18.0%` is said again and again.
# A whole one is what it is about: joint 1 and joint 2 are two faults; 10.0.0.1 is a name as well.
_READING = re.compile(r"-?(?<![\d.])\d+\.\d+(?!\.?\d)")


def _common(level: str, source: str, text: str) -> object:
    """What an event has in common with those that repeat it."""
    return level, source, _READING.sub("#", text)


class EventLog:
    """Collects events; one that repeats another but for its readings replaces it."""

    def __init__(self) -> None:
        self._count = 0
        # by what repeats have in common; each with its place among all of them
        self._own: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._routine: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._worse: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._all: tuple[Event, ...] | None = ()  # None: not put in order yet
        self._windows: dict[str, tuple[float, int]] = {}  # by source: since when (s), lines since

    def add(self, event: Event) -> Event:
        """Append an event, or count it on the one it repeats. The console's own are never merged.

        Returns it as it stands in the log.
        """
        self._count += 1
        self._all = None
        text, source = harmless(event.text), harmless(event.source)
        kept, key = self._place(event.level, source, text)
        if event.level in ROUTINE and key not in kept and not self._has_room(source, event.time):
            text = LEFT_OUT
            kept, key = self._place(event.level, source, text)
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
        if len(self._own) > _OWN:
            self._own.popitem(last=False)
        if len(self._routine) + len(self._worse) > LIMIT - _OWN:
            max(self._routine, self._worse, key=len).popitem(last=False)
        return event

    def _has_room(self, source: str, time: float) -> bool:
        """Return False when a source said too many different lines of late, and count one more."""
        since, lines = self._windows.get(source, (time, 0))
        if not 0 <= time - since < _PERIOD:
            since, lines = time, 0
        if len(self._windows) > LIMIT:  # names that nobody uses any more
            self._windows.clear()
        self._windows[source] = since, lines + 1
        return lines < MOST_LINES

    def _place(
        self, level: str, source: str, text: str
    ) -> tuple[OrderedDict[object, tuple[int, Event]], object]:
        """Where such an event is kept, and by what its repeats are known."""
        if level in OWN_LEVELS:
            return self._own, self._count
        return self._routine if level in ROUTINE else self._worse, _common(level, source, text)

    @classmethod
    def of(cls, events: Iterable[Event]) -> EventLog:
        """One that has these, oldest first."""
        log, events = cls(), tuple(events)
        for log._count, event in enumerate(events, 1):
            kept, key = log._place(event.level, event.source, event.text)
            kept[key] = log._count, event
        log._count = max(
            log._count, *(event.number for event in events), 0
        )  # further on from there
        log._all = None
        return log

    def copy(self) -> EventLog:
        """Another one with the same events."""
        log = EventLog()
        log._count, log._all = self._count, self._all
        log._own, log._routine = self._own.copy(), self._routine.copy()
        log._worse, log._windows = self._worse.copy(), self._windows.copy()
        return log

    def all(self) -> tuple[Event, ...]:
        """Oldest first; the same object until one is added."""
        if self._all is None:
            places = (*self._own.values(), *self._routine.values(), *self._worse.values())
            self._all = tuple(event for _, event in sorted(places, key=itemgetter(0)))
        return self._all
