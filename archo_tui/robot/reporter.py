"""The reports of what this console did, and the log of its events."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_msgs.msg import String

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.robot.clients import YOU, Requester, UnexplainedChanges, author
from archo_tui.robot.outcome import Code
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event, EventLog
from archo_tui.safe_text import harmless

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
        self._on_event(self.log.add(event))
        self._on_change()

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
