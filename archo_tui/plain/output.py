"""The writer of what `--plain` prints, on a thread of its own: a reader may stall."""

from __future__ import annotations

import asyncio
import contextlib
import os
import select
import threading
from collections.abc import Callable

MAX_WAITING = 1_000_000  # Bytes that wait to be written.
_CHUNK = 4096  # Bytes written at once, unless a line is longer.


class Output:
    """A file descriptor to which whole lines are written, on a thread of its own.

    When more than MAX_WAITING bytes wait, the oldest lines are dropped, and a line in their place
    tells how many.
    """

    def __init__(self, descriptor: int, on_change: Callable[[], None]) -> None:
        """Create the output; `start` begins to write, and the descriptor stays open.

        `on_change` is called on the running loop when `has_room` or `is_done` may be true again,
        and when a write has failed.
        """
        self._descriptor, self._on_change = descriptor, on_change
        self._loop = asyncio.get_running_loop()
        self._condition = threading.Condition()  # Guards the attributes below; notified by `put`.
        self._waiting = bytearray()
        self._dropped = 0  # Lines dropped since the last line that told how many.
        self._is_writing = self._is_closed = False
        self.is_broken = False  # True once the reader has left, or the disk is full.

    def start(self) -> None:
        threading.Thread(target=self._run, name="stdout", daemon=True).start()

    def put(self, lines: bytes) -> None:
        """Add whole lines to be written, and return at once; drop the oldest if too many wait."""
        with self._condition:
            self._waiting += lines
            if len(self._waiting) > MAX_WAITING:
                end = self._waiting.find(b"\n", len(self._waiting) - MAX_WAITING - 1) + 1
                self._dropped += self._waiting.count(b"\n", 0, end)
                del self._waiting[:end]
            self._condition.notify()

    @property
    def has_room(self) -> bool:
        """True while less than half of MAX_WAITING bytes wait, or after a write has failed."""
        return self.is_broken or len(self._waiting) < MAX_WAITING // 2

    @property
    def is_done(self) -> bool:
        """True while every line is written or dropped and reported, or after a write has failed."""
        return self.is_broken or not (self._waiting or self._dropped or self._is_writing)

    def close(self) -> None:
        """Let the thread end once it has written the waiting lines, without waiting for it."""
        with self._condition:
            self._is_closed = True
            self._condition.notify()

    # Called on the thread.

    def _run(self) -> None:
        try:
            while chunk := self._next_chunk():
                self._write(chunk)
        except OSError:
            self.is_broken = True
            self._announce()

    def _next_chunk(self) -> bytes:
        """Wait for lines, and return the next ones; empty once all is written after `close()`."""
        with self._condition:
            self._is_writing = False
            if self.is_done:
                self._announce()
            self._condition.wait_for(lambda: not self.is_done or self._is_closed)
            self._is_writing = True  # Before lines are taken: `is_done` is read without the lock.
            had_room, dropped, self._dropped = self.has_room, self._dropped, 0
            # As many whole lines as fit, or the first line if none fits.
            end = self._waiting.rfind(b"\n", 0, _CHUNK) + 1 or self._waiting.find(b"\n") + 1
            chunk = bytes(self._waiting[:end])
            del self._waiting[:end]
            self._is_writing = bool(chunk)
            if self.has_room and not had_room:
                self._announce()
        if not dropped:
            return chunk
        lines = "1 line was" if dropped == 1 else f"{dropped} lines were"
        return f"... {lines} left out: the reader was too slow\n".encode() + chunk

    def _announce(self) -> None:
        with contextlib.suppress(RuntimeError):  # The loop is closed: nobody waits for it.
            self._loop.call_soon_threadsafe(self._on_change)

    def _write(self, data: bytes) -> None:
        """Write all bytes, however long the reader takes; OSError once it has left."""
        while data:
            try:
                data = data[os.write(self._descriptor, data) :]
            # Another process that shares the descriptor made it non-blocking.
            except BlockingIOError:
                select.select([], [self._descriptor], [])
