"""What `--plain` prints: written beside all else, since its reader may stall."""

from __future__ import annotations

import asyncio
import contextlib
import os
import select
import threading
from collections.abc import Callable

MOST = 1_000_000  # bytes that wait for the reader
_PIECE = 4096  # bytes that are written in one go


class Output:
    """Writes whole lines to a file descriptor, on a thread of its own.

    When too much waits, the oldest lines are left out, and a line says how many.
    """

    def __init__(self, descriptor: int, changed: Callable[[], None]) -> None:
        """`changed()` is called on the running loop when there is room again or all is done."""
        self._descriptor, self._changed = descriptor, changed
        self._loop = asyncio.get_running_loop()
        self._condition = threading.Condition()
        self._waiting = bytearray()
        self._left_out = 0
        self._is_writing = self._closed = False
        self.is_broken = False  # nobody reads any more, or there is no room

    def start(self) -> None:
        """Begin to write."""
        threading.Thread(target=self._run, name="stdout", daemon=True).start()

    def put(self, lines: bytes) -> None:
        """Have these whole lines written."""
        with self._condition:
            self._waiting += lines
            if len(self._waiting) > MOST:
                end = self._waiting.find(b"\n", len(self._waiting) - MOST - 1) + 1
                self._left_out += self._waiting.count(b"\n", 0, end)
                del self._waiting[:end]
            self._condition.notify()

    @property
    def has_room(self) -> bool:
        """True while nothing is about to be left out."""
        return self.is_broken or len(self._waiting) < MOST // 2

    @property
    def is_done(self) -> bool:
        """True when all is written, or cannot be."""
        return self.is_broken or not (self._waiting or self._left_out or self._is_writing)

    def close(self) -> None:
        """Nothing more comes: the thread ends after what it can write."""
        with self._condition:
            self._closed = True
            self._condition.notify()

    # on the thread

    def _run(self) -> None:
        try:
            while piece := self._next():
                self._write(piece)
        except OSError:
            self.is_broken = True
            self._tell()

    def _next(self) -> bytes:
        """The next whole lines, as soon as there are some; none at the end."""
        with self._condition:
            self._is_writing = False
            if self.is_done:
                self._tell()
            self._condition.wait_for(lambda: not self.is_done or self._closed)
            had_room, left_out, self._left_out = self.has_room, self._left_out, 0
            end = self._waiting.rfind(b"\n", 0, _PIECE) + 1 or self._waiting.find(b"\n") + 1
            piece = bytes(self._waiting[:end])
            del self._waiting[:end]
            self._is_writing = bool(piece)
            if self.has_room and not had_room:
                self._tell()
        if not left_out:
            return piece
        lines = "1 line was" if left_out == 1 else f"{left_out} lines were"
        return f"... {lines} left out: the reader was too slow\n".encode() + piece

    def _tell(self) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed: nobody asks
            self._loop.call_soon_threadsafe(self._changed)

    def _write(self, data: bytes) -> None:
        while data:
            try:
                data = data[os.write(self._descriptor, data) :]
            except BlockingIOError:  # whoever else has it has made it so
                select.select([], [self._descriptor], [])
