"""The sending of snapshots to the front end: a few each second, however much happens."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable

from rclpy.clock import Clock as RosClock
from rclpy.node import Node

from archo_tui.robot.state.snapshot import Snapshot

PERIOD = 0.25  # Seconds between two snapshots while much happens: nobody reads faster.


class SnapshotSender:
    """The sender of snapshots: has them built, and puts them into the mailbox. ROS thread only."""

    def __init__(self, node: Node, clock: RosClock, build: Callable[[], Snapshot]) -> None:
        self._build = build
        self.mailbox = Mailbox()  # The way to the front end; it holds the newest snapshot only.
        # True if a message with a reading came since the last snapshot, even one that changed
        # nothing.
        self.is_stale = False
        self._timer = node.create_timer(PERIOD, self.send, clock=clock)
        self._timer.cancel()

    def send_soon(self) -> None:
        """Have a snapshot sent within PERIOD; more calls before that change nothing."""
        if self._timer.is_canceled():
            self._timer.reset()

    def send(self) -> None:
        """Build a snapshot and put it into the mailbox now, in place of any that is due."""
        self.is_stale = False
        self._timer.cancel()
        self.mailbox.put(self._build())


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
        """Call a function on the running loop with each snapshot that is put from now on.

        The function takes the place of an earlier one. The newest snapshot is not delivered again.
        """
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
        """Replace the newest snapshot, and have it delivered on the loop. Any thread.

        A snapshot that still waits is never delivered. Before `open` nothing is delivered.
        """
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
