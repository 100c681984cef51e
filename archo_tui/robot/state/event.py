"""A line of the list of events."""

from __future__ import annotations

from dataclasses import dataclass

from archo_tui.robot.audit_records import AuditRecord

# The levels of the console's own events: what the person, a shell or an assistant did, how goals
# ended, and what other consoles did.
OWN_LEVELS = ("YOU", "SHELL", "AI", "GOAL", "PEER")
LAUNCH = "launch"  # The source of what the user's launch file says.


@dataclass(frozen=True)  # A tuple has a `count` of its own.
class Event:
    """A log line of a node, or an event of the console. The times are Unix times of the receipt."""

    time: float  # When it was received; for equal events, when the last of them was.
    level: str  # `DEBUG`, `INFO`, `WARN`, `ERROR`, `FATAL`, or one of OWN_LEVELS.
    source: str  # The name of the logger, or who or what the event is about.
    text: str  # The line.
    command: str = ""  # The `ros2` command line that does the same; "" if there is none.
    count: int = 1  # The number of equal events for which this one stands.
    first: float = 0.0  # When the first of these was received.
    number: int = 0  # The number of the first of these, which no other event has.
    audit_record: AuditRecord | None = None  # The record of what was done; None if nothing was.
    code: str = ""  # The code of its outcome, which recordings keep, too; "" if none is known.
