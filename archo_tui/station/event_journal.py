"""The choice of the events that the journal gets: commands, warnings, and what others did."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.robot.state import Event
from archo_tui.station.journal import Journal, RepeatFilter

_KINDS = {
    "YOU": "command",
    "SHELL": "command",
    "AI": "command",
    "GOAL": "goal",
    "PEER": "other console",
}  # Other levels are events.
# The counts of a repeated event that the journal notes.
_COUNTS = (1, 10, 100, 1000, 10_000, 100_000)


class EventJournal:
    """The writer of a console's events, with the robot's `place`, to the `Journal`."""

    def __init__(self, journal: Journal, place: Mapping[str, Any]) -> None:
        self._journal, self._place = journal, place
        self._repeat_filter = RepeatFilter()

    def record(self, event: Event) -> None:
        """Write an event, unless it is DEBUG, INFO, or one of many repeats.

        Of a node's lines that differ in numbers only, a `RepeatFilter` chooses. The line of a STOP
        or a release has the key `place`. Called on the robot's thread, without waiting for the
        disk.
        """
        if event.level in ("DEBUG", "INFO") or event.count not in _COUNTS:
            return
        kind = _KINDS.get(event.level, "event")
        by_node = kind == "event" and event.source != "console"
        is_new = by_node and event.count == 1
        if is_new and not self._repeat_filter.passes(event.source, event.text):
            return
        what: dict[str, Any] = {
            "level": event.level,
            "source": event.source,
            "text": event.text,
        }
        if event.command:
            what["command"] = event.command
        if event.audit_record is not None:
            what |= event.audit_record._asdict()
            if event.audit_record.verb in ("stop", "release"):
                what["place"] = self._place
        self._journal.write(event.time, kind, **what, count=event.count)
