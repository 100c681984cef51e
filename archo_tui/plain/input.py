"""What is typed into `--plain`: read without a pause, since a STOP may come behind it."""

from __future__ import annotations

import asyncio
import contextlib
import os
import select
import sys
import threading
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from archo_tui.clock import Clock
from archo_tui.plain.lines import LONGEST, TOO_LONG, LineCutter, is_stop, words_of
from archo_tui.robot.stops import Stops

_SHOWN = 40  # bytes of a wrong line that are shown
MOST = 1024 * 1024  # bytes of lines that wait
_CHUNK = 64 * 1024  # bytes: what a pipe holds, so that what is written in one go is read in one go


class Line(NamedTuple):
    """One that is to be carried out."""

    text: str
    stops: int  # that had been read before it
    fault: str = ""  # why it is not


class Input:
    """Reads a file descriptor on a thread of its own, and counts the STOPs among the lines.

    It does so there, for the loop may be at work on what was typed before. The other lines wait
    here, each with the count at its place, until they are taken.
    """

    def __init__(
        self, descriptor: int | None, stops: Stops, heard: Callable[[], None], clock: Clock
    ) -> None:
        """`heard()` is called on the running loop after something came, or the end.

        `descriptor` is None where there is no input.
        """
        self._descriptor, self._stops, self._heard = descriptor, stops, heard
        self._clock = clock
        self.last = 0.0, 0.0  # monotonic s when the last line was read; s since the one before
        self._loop = asyncio.get_running_loop()
        self.is_terminal = descriptor is not None and os.isatty(descriptor)
        self._thread = threading.Thread(target=self._listen, name="stdin", daemon=True)
        self._lock = threading.Lock()
        # the counts and the lines: as objects they would take many times the room
        self._waiting = bytearray()
        self._size = 0  # bytes of the lines alone
        self._is_full = False
        self._told = False  # the loop, and it has not looked yet
        self._closed = False
        self._at_work = False  # the thread, with what is not counted or kept yet
        self.has_ended = False  # lines may wait still
        self.unanswered: deque[int] = deque()  # the numbers of the STOPs that were typed
        self.overflows = 0  # how often it has begun to refuse lines

    def start(self) -> None:
        """Begin to read; no buffered reader, which would delay the end of the process."""
        self._thread.start()

    def close(self) -> None:
        """What is read from now on is left alone."""
        self._closed = True

    @property
    def is_reading(self) -> bool:
        """True until the end of the input, or the first thing that comes after `close()`."""
        return self._thread.is_alive()

    @property
    def has_news(self) -> bool:
        """True when a line waits, or none comes any more."""
        return bool(self._waiting) or self.has_ended

    @property
    def is_cancel_next(self) -> bool:
        """True when the line that has waited longest is `cancel`."""
        with self._lock:
            end = max(self._waiting.find(b"\n"), 0)
            _, _, text = self._waiting[:end].partition(b" ")
        return text.split() == [b"cancel"]

    @property
    def is_quiet(self) -> bool:
        """True when nothing is there to be read, and what was read is kept."""
        if self._descriptor is None or self.has_ended or self._closed:
            return True
        if sys.platform == "win32":  # its select knows no pipes
            return True
        # in this order: the thread is at work before it takes something away
        return not select.select([self._descriptor], [], [], 0)[0] and not self._at_work

    def take(self) -> Line | None:
        """The line that has waited longest; None when there is none."""
        with self._lock:
            end = self._waiting.find(b"\n")
            entry = bytes(self._waiting[: max(end, 0)])
            del self._waiting[: end + 1]
            stops, mark, text = entry.partition(b" ")
            self._size -= len(text)
            self._is_full = self._is_full and self._size > MOST // 2
        if not entry:
            return None
        if not mark:
            return Line("", int(stops), f"a line of more than {LONGEST} bytes")
        try:
            return Line(text.decode(), int(stops))
        except UnicodeDecodeError:  # whatever stood for its characters would be sent
            shown = text[:_SHOWN].decode(errors="replace")
            return Line("", int(stops), f"a line that is not UTF-8: {shown}")

    # on the thread

    def _listen(self) -> None:
        lines = LineCutter()
        while (chunk := self._chunk()) and not self._closed:
            read = lines.take(chunk)
            for _ in read:
                now = self._clock.monotonic()
                self.last = now, now - self.last[0]
            self._keep(read)
            self._at_work = False
            self._tell()
        self._keep(lines.take(b"\n"))
        self.has_ended = True
        self._tell()

    def _chunk(self) -> bytes:
        while self._descriptor is not None:
            try:
                if sys.platform != "win32":
                    select.select([self._descriptor], [], [])
                self._at_work = True
                return os.read(self._descriptor, _CHUNK)
            except BlockingIOError:  # whoever else has it has made it so, and was faster
                self._at_work = False
            except OSError:
                break
        return b""

    def _keep(self, lines: list[bytes]) -> None:
        stops = self._stops.count
        entries = []
        for line in lines:
            if is_stop(line) or (b"call" in line and self._stops.is_stop_call(words_of(line))):
                stops = self._stops.register()
                self.unanswered.append(stops)
            elif line == TOO_LONG:
                entries.append((b"%d\n" % stops, 0))
            elif line.strip() or self.is_terminal:  # there a return is an answer
                entries.append((b"%d %b\n" % (stops, line), len(line)))
        with self._lock:
            for entry, size in entries:
                if not self._is_full and self._size + size > MOST:
                    self._is_full = True
                    self.overflows += 1
                if not self._is_full:
                    self._waiting += entry
                    self._size += size

    def _tell(self) -> None:
        if not self._told:
            self._told = True
            with contextlib.suppress(RuntimeError):  # the loop is closed: nobody listens
                self._loop.call_soon_threadsafe(self._look)

    def _look(self) -> None:
        self._told = False
        self._heard()
