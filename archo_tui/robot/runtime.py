"""What all parts of the robot's side share: node, ROS thread, log of events, and snapshots."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable, Mapping
from typing import Any

from rclpy.context import Context
from std_msgs.msg import String

from archo_tui.base.clock import Clock
from archo_tui.base.errors import in_one_line
from archo_tui.base.safe_text import harmless
from archo_tui.robot.clients import YOU, Requester, UnexplainedChanges, author, new_node_name
from archo_tui.robot.node import ConsoleNode, MessageCallback
from archo_tui.robot.outcome import Code
from archo_tui.robot.ros_thread import RosThread
from archo_tui.robot.state import audit_records
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event, EventLog
from archo_tui.robot.state.snapshot import Snapshot

MAX_UNREAD = 100  # Audit records of other consoles that are kept while the thread is busy.
PERIOD = 0.25  # Seconds between two snapshots while much happens: nobody reads faster.


class Runtime:
    """The record of what every part uses; the parts change on the ROS thread only."""

    def __init__(
        self,
        context: Context,
        clock: Clock,
        on_event: Callable[[Event], None],
        on_message: MessageCallback,
        masks: Mapping[Any, Callable[[Any], Any]],
    ) -> None:
        self.clock = clock  # Any thread may use it, and `thread`.
        node = self.node = ConsoleNode(new_node_name(), context, on_message, masks)
        self.thread = RosThread(node, context, clock, lambda error: self.reporter.error(error))
        self.snapshots = SnapshotSender(node, self._build_snapshot)
        self.changes = UnexplainedChanges()
        self.reporter = Reporter(node, clock, self.changes, on_event, self.snapshots.send_soon)

    def _build_snapshot(self) -> Snapshot:
        raise NotImplementedError


Receiver = Callable[[Snapshot], None]


class Mailbox:
    """The place of the newest snapshot: only one waits for delivery, however slow the loop."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._latest = Snapshot()
        self._waiting = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._receiver: Receiver | None = None

    def open(self, receiver: Receiver) -> None:
        """Call a function on the running loop with each snapshot that is put from now on."""
        with self._lock:
            self._waiting = False  # A delivery that an earlier loop did not get to is lost.
            self._loop = asyncio.get_running_loop()
            self._receiver = receiver

    def close(self) -> None:
        """Deliver no more snapshots; `put` and `latest` still work."""
        self._receiver = None

    @property
    def latest(self) -> Snapshot:
        """The snapshot that was put last; an empty one before the first."""
        return self._latest

    def put(self, snapshot: Snapshot) -> None:
        """Replace the newest snapshot, and have it delivered on the loop. Any thread."""
        with self._lock:
            self._latest = snapshot
            if self._waiting or self._loop is None:
                return
            self._waiting = True
        with contextlib.suppress(RuntimeError):  # The loop is closed.
            self._loop.call_soon_threadsafe(self._deliver)

    def _deliver(self) -> None:
        with self._lock:
            self._waiting = False
            snapshot = self._latest
        if self._receiver is not None:
            self._receiver(snapshot)


class SnapshotSender(Mailbox):
    """The mailbox with its sender, which has snapshots built on the ROS thread."""

    def __init__(self, node: ConsoleNode, build: Callable[[], Snapshot]) -> None:
        super().__init__()
        self._build = build
        # True if a message with a reading came since the last snapshot, even one that changed
        # nothing.
        self.is_stale = False
        self._timer = node.create_steady_timer(PERIOD, self.send)
        self._timer.cancel()

    def send_soon(self) -> None:
        """Have a snapshot sent within PERIOD; more calls before that change nothing."""
        if self._timer.is_canceled():
            self._timer.reset()

    def send(self) -> None:
        """Build a snapshot and put it now, in place of any that is due."""
        self.is_stale = False
        self._timer.cancel()
        self.put(self._build())


class Reporter:
    """The log of this console's events, and the reports to other consoles of what it did."""

    def __init__(
        self,
        node: ConsoleNode,
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
        """Report what this console did: as an event, in the ROS log, and to other consoles."""
        text = harmless(text)
        self._node.get_logger().info(text)
        self._publisher.publish(String(data=audit_records.to_json(self._console, record, text)))
        self._changes.on_audit_record(record, self._clock.monotonic())
        now = self._clock.now()
        self.add(Event(now, requester.level, requester.source, text, command, audit_record=record))

    def report_stop_result(self, text: str, code: Code) -> None:
        """Report an outcome of a STOP that no verb waits for any more, as `report_done` does."""
        self.report_done(text, AuditRecord("stop", {"later": True}, code))
