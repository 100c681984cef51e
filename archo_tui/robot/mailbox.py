"""The way of snapshots from the ROS thread to the frontend's loop."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable

from archo_tui.robot.state import Snapshot

Receiver = Callable[[Snapshot], None]


class Mailbox:
    """A place for the newest snapshot: at most one waits, however slow the loop is."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._latest = Snapshot()
        self._waiting = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._receiver: Receiver | None = None

    def open(self, receiver: Receiver) -> None:
        """Call `receiver` on the running loop with each snapshot from now on."""
        with self._lock:
            self._waiting = False  # A delivery that an earlier loop did not get to is lost.
            self._loop = asyncio.get_running_loop()
            self._receiver = receiver

    def close(self) -> None:
        """Stop delivering."""
        self._receiver = None

    @property
    def latest(self) -> Snapshot:
        """The newest snapshot."""
        return self._latest

    def put(self, snapshot: Snapshot) -> None:
        """Replace the newest snapshot, and have it delivered. Any thread."""
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
