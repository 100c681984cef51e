"""The delivery of snapshots from the ROS thread to the front end's event loop."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable

from archo_tui.robot.state import Snapshot

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
