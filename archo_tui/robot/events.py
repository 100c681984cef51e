"""The events of this session: the log of bounded length, and the reports of what happens."""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Callable, Iterable
from operator import itemgetter

from rclpy.node import Node
from std_msgs.msg import String

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.robot.clients.changes import UnexplainedChanges
from archo_tui.robot.clients.consoles import author
from archo_tui.robot.clients.requester import YOU, Requester
from archo_tui.robot.outcome import Code
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.snapshot import OWN_LEVELS, Event
from archo_tui.safe_text import harmless, harmless_lines

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
        is_log_line = event.level not in OWN_LEVELS
        text = harmless_lines(event.text) if is_log_line else harmless(event.text)
        source = harmless(event.source)
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

    def all(self) -> tuple[Event, ...]:
        """Return all events, the one that was last received or repeated at the end.

        The tuple is the same object until an event is added.
        """
        if self._all is None:
            places = (*self._own.values(), *self._routine.values(), *self._worse.values())
            self._all = tuple(event for _, event in sorted(places, key=itemgetter(0)))
        return self._all


MAX_UNREAD = 100  # Audit records of other consoles that are kept while the thread is busy.


class Reporter:
    """The log of this console's events, and the reports to other consoles of what it did.

    ROS thread only.
    """

    def __init__(
        self,
        node: Node,
        clock: Clock,
        changes: UnexplainedChanges,
        on_event: Callable[[Event], None],
        on_change: Callable[[], None],
    ) -> None:
        self._node, self._clock, self._changes = node, clock, changes
        self._on_event, self._on_change = on_event, on_change
        self._console = author(node.get_name())
        self._publisher = node.create_publisher(String, audit_records.TOPIC, MAX_UNREAD)
        self.log = EventLog()  # The events so far.

    def add(self, event: Event) -> None:
        """Add an event to the log, pass it to `on_event`, and have the front ends show it."""
        self.add_log_line(event)
        self._on_change()

    def add_log_line(self, event: Event) -> Event:
        """Add an event to the log and pass it to `on_event`; nothing is shown yet."""
        added = self.log.add(event)
        self._on_event(added)
        return added

    def note(self, level: str, text: str) -> None:
        """Add an event whose source is the console."""
        self.add(Event(self._clock.now(), level, "console", text))

    def warn(self, text: str) -> None:
        """Add an event of level WARN whose source is the console."""
        self.note("WARN", text)

    def error(self, error: Exception) -> None:
        """Add an event of level ERROR with the text of an exception; the source is the console."""
        self.note("ERROR", in_one_line(error))

    def report_done(
        self, text: str, record: AuditRecord, command: str = "", requester: Requester = YOU
    ) -> None:
        """Report what this console did: as an event, in the ROS log, and to other consoles.

        The record also explains changes of the robot that follow, so that no other client is
        blamed.
        """
        text = harmless(text)
        self._node.get_logger().info(text)
        self._publisher.publish(String(data=audit_records.to_json(self._console, record, text)))
        self._changes.on_audit_record(record, self._clock.monotonic())
        now = self._clock.now()
        self.add(Event(now, requester.level, requester.source, text, command, audit_record=record))

    def report_stop_result(self, text: str, code: Code) -> None:
        """Report an outcome of a STOP that no verb waits for any more, as `report_done` does."""
        self.report_done(text, AuditRecord("stop", {"later": True}, code))

    def report_cancel_of_others(self, text: str, code: Code) -> None:
        """Report that goals of other clients were cancelled behind a STOP that is not confirmed."""
        self.report_done(text, AuditRecord("cancel", {"all": True}, code))
