"""The events of this session: lines of nodes and of the console, in a log of bounded length."""

from __future__ import annotations

import math
import re
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass
from operator import itemgetter

from archo_tui.base.clock import UnixTime
from archo_tui.base.safe_text import harmless, harmless_lines
from archo_tui.robot.state.audit_records import AuditRecord

# The levels of the console's own events: what the person, a shell or an assistant did, how goals
# ended, and what other consoles did.
OWN_LEVELS = ("YOU", "SHELL", "AI", "GOAL", "PEER")
LAUNCH = "launch"  # The source of what the user's launch file says.


@dataclass(frozen=True)  # A tuple has a `count` of its own.
class Event:
    """A log line of a node, or an event of the console. The times are Unix times of the receipt."""

    time: UnixTime  # When it was received; for equal events, when the last of them was.
    level: str  # `DEBUG`, `INFO`, `WARN`, `ERROR`, `FATAL`, or one of OWN_LEVELS.
    source: str  # The name of the logger, or who or what the event is about.
    text: str
    command: str = ""  # The `ros2` command line that does the same; "" if there is none.
    count: int = 1  # The number of equal events for which this one stands.
    first: UnixTime = 0.0  # When the first of these was received.
    number: int = 0  # The number of the first of these, which no other event has.
    audit_record: AuditRecord | None = None  # The record of what was done; None if nothing was.
    code: str = ""  # The code of its outcome, which recordings keep, too; "" if none is known.


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


class LineCounter:
    """A counter of lines by what they have in common, which begins again in each period."""

    def __init__(self, period: float = math.inf) -> None:
        self._period = period
        # When the present period of a key began, in Unix seconds, and the lines in it.
        self._counts: dict[object, tuple[float, int]] = {}

    def count(self, key: object, time: float) -> int:
        """Count a line at a Unix time; return how many there are of its key, with this one."""
        since, lines = self._counts.pop(key, (time, 0))
        if not 0 <= time - since < self._period:
            since, lines = time, 0
        self._counts[key] = since, lines + 1
        if len(self._counts) > LIMIT:
            del self._counts[next(iter(self._counts))]
        return lines + 1


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
        self._lines = LineCounter(_PERIOD)  # By source.

    def add(self, event: Event) -> Event:
        """Append an event, or replace the earlier event that it repeats, and count the repeat."""
        self._count += 1
        self._all = None
        is_log_line = event.level not in OWN_LEVELS
        text = harmless_lines(event.text) if is_log_line else harmless(event.text)
        source = harmless(event.source)
        kept, key = self._place(event.level, source, text)
        is_new = event.level in ROUTINE and key not in kept
        if is_new and self._lines.count(source, event.time) > MOST_LINES:
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

    def all(self) -> tuple[Event, ...]:
        """Return all events, the last one at the end; the same tuple until an event is added."""
        if self._all is None:
            places = (*self._own.values(), *self._routine.values(), *self._worse.values())
            self._all = tuple(event for _, event in sorted(places, key=itemgetter(0)))
        return self._all
