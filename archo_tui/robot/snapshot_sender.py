"""The sending of snapshots to the front end: a few each second, however much happens."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock as RosClock
from rclpy.node import Node

from archo_tui.robot.mailbox import Mailbox
from archo_tui.robot.state import Snapshot

FLUSH_PERIOD = 0.2  # Seconds between two snapshots while much happens: 5 a second.
# Seconds between two while only numbers change and nodes log: nobody reads faster.
STREAM_PERIOD = 0.4


class SnapshotSender:
    """The sender of snapshots: has them built, and puts them into the mailbox. ROS thread only."""

    def __init__(self, node: Node, clock: RosClock, build: Callable[[], Snapshot]) -> None:
        self._build = build
        self.mailbox = Mailbox()  # The way to the front end; it holds the newest snapshot only.
        # True if a message with a reading came since the last snapshot, even one that changed
        # nothing.
        self.is_stale = False
        # True while a snapshot is due within FLUSH_PERIOD, and within STREAM_PERIOD.
        self._is_due_soon = self._is_due_later = False
        self._flusher = node.create_timer(FLUSH_PERIOD, self.send, clock=clock)
        self._flusher.cancel()
        self._streamer = node.create_timer(STREAM_PERIOD, self.send, clock=clock)
        self._streamer.cancel()

    def send_soon(self) -> None:
        """Have a snapshot sent within FLUSH_PERIOD; more calls before that change nothing."""
        if not self._is_due_soon:
            self._is_due_soon = True
            self._flusher.reset()

    def send_later(self) -> None:
        """Have a snapshot sent within STREAM_PERIOD, unless one is due already.

        Use it if only readings changed, or nodes logged: `send_soon` sends one earlier.
        """
        if not (self._is_due_soon or self._is_due_later):
            self._is_due_later = True
            self._streamer.reset()

    def send(self) -> None:
        """Build a snapshot and put it into the mailbox now, in place of any that is due."""
        self._is_due_soon = self._is_due_later = self.is_stale = False
        self._flusher.cancel()
        self._streamer.cancel()
        self.mailbox.put(self._build())
