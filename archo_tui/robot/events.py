"""The log of the session's events, of bounded length, in which repeats are counted."""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Iterable
from operator import itemgetter

from archo_tui.robot.state import OWN_LEVELS, Event
from archo_tui.safe_text import harmless

LIMIT = 1000  # Events that are kept.
_OWN = 200  # Of these, the console's own, which a flood of others does not push out.
ROUTINE = ("DEBUG", "INFO")  # Levels of frequent logs, which push out nothing worse.
MOST_LINES = 50  # Different ROUTINE lines of one source that are kept in a `_PERIOD`.
_PERIOD = 1.0  # Seconds.
LEFT_OUT = f"lines were left out: more than {MOST_LINES} in a second"

# A number with a decimal point is a reading, which drifts: `Low battery: 18.0%` is a repeat of the
# line with 18.1%. A whole number is part of a name: joint 1 and joint 2 are two faults. 10.0.0.1 is
# an address, no reading.
_READING = re.compile(r"-?(?<![\d.])\d+\.\d+(?!\.?\d)")


def _repeat_key(level: str, source: str, text: str) -> object:
    """Return a key that is the same for events that differ only in their decimal numbers."""
    return level, source, _READING.sub("#", text)


class EventLog:
    """A log in which a log line replaces an earlier line that differs only in its decimal numbers.

    At most 200 events of the console itself (OWN_LEVELS) and 800 lines of nodes are kept. Of too
    many lines of nodes, the oldest goes of those that are more: DEBUG and INFO, or all others.
    """

    def __init__(self) -> None:
        self._count = 0
        # By the key that repeats share; each with its place in the order of all events.
        self._own: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._routine: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._worse: OrderedDict[object, tuple[int, Event]] = OrderedDict()
        self._all: tuple[Event, ...] | None = ()  # None: not sorted yet.
        # By source: the beginning of the present `_PERIOD` (Unix seconds), and lines in it.
        self._windows: dict[str, tuple[float, int]] = {}

    def add(self, event: Event) -> Event:
        """Append an event, or replace the earlier event that it repeats, and count the repeat.

        The console's own events are never repeats. If the log is full, an old event is dropped.
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
            audit_record=None if event.audit_record is None else event.audit_record.json_safe(),
            code=event.code if event.audit_record is None else event.audit_record.code.value,
        )
        kept[key] = self._count, event
        if len(self._own) > _OWN:
            self._own.popitem(last=False)
        if len(self._routine) + len(self._worse) > LIMIT - _OWN:
            max(self._routine, self._worse, key=len).popitem(last=False)
        return event

    def _has_room(self, source: str, time: float) -> bool:
        """Count a line of a source; return False if 50 came before it in the present second."""
        since, lines = self._windows.get(source, (time, 0))
        if not 0 <= time - since < _PERIOD:
            since, lines = time, 0
        if len(self._windows) > LIMIT:  # Most are names that nobody uses any more.
            self._windows.clear()
        self._windows[source] = since, lines + 1
        return lines < MOST_LINES

    def _place(
        self, level: str, source: str, text: str
    ) -> tuple[OrderedDict[object, tuple[int, Event]], object]:
        """Return the part of the log in which such an event is kept, and its key there."""
        if level in OWN_LEVELS:
            return self._own, self._count
        return self._routine if level in ROUTINE else self._worse, _repeat_key(level, source, text)

    @classmethod
    def of(cls, events: Iterable[Event]) -> EventLog:
        """Return a new log with these events, unchanged."""
        log, events = cls(), tuple(events)
        for log._count, event in enumerate(events, 1):
            kept, key = log._place(event.level, event.source, event.text)
            kept[key] = log._count, event
        # Later events get higher numbers than all of these.
        log._count = max(log._count, *(event.number for event in events), 0)
        log._all = None
        return log

    def copy(self) -> EventLog:
        """Return an independent log with the same events."""
        log = EventLog()
        log._count, log._all = self._count, self._all
        log._own, log._routine = self._own.copy(), self._routine.copy()
        log._worse, log._windows = self._worse.copy(), self._windows.copy()
        return log

    def all(self) -> tuple[Event, ...]:
        """Return all events, the one that was last received or repeated at the end.

        The tuple is the same object until an event is added.
        """
        if self._all is None:
            places = (*self._own.values(), *self._routine.values(), *self._worse.values())
            self._all = tuple(event for _, event in sorted(places, key=itemgetter(0)))
        return self._all
