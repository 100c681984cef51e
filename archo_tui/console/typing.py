"""The reader of typed lines, also while one is carried out: a STOP may be behind it."""

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

from archo_tui.base.clock import Clock
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop.words import is_stop, shell_words

MAX_WAITING = 1024 * 1024  # Bytes of lines that wait to be carried out.
MAX_LINES = 20_000  # Lines that wait: short ones take more memory than their bytes.
MAX_LINE = 64 * 1024  # Bytes of a line that is accepted.
TOO_LONG = b"\n"  # Stands for a longer line; no line can be equal to it.
_SHOWN = 40  # Bytes of a line that is not UTF-8 which its error quotes.
_CHUNK = 64 * 1024  # Bytes; a pipe holds as many, so what is written at once is read at once.


class LineSplitter:
    """A splitter of a stream of bytes into lines, which keeps the unfinished last line."""

    def __init__(self) -> None:
        self._rest = bytearray()  # The beginning of a line whose end was not read yet.
        self._is_skipping = False  # The end of a line that is too long.

    def feed(self, chunk: bytes) -> list[bytes]:
        """Return the lines that end in this chunk, at a line feed or a carriage return.

        A line beyond `MAX_LINE` is returned as soon as it is: as its beginning if that is a STOP,
        else as `TOO_LONG`. The rest of it is dropped.
        """
        first, *others = chunk.replace(b"\r", b"\n").split(b"\n")  # A raw terminal sends returns.
        lines: list[bytes] = []
        self._append(first, lines)
        for part in others:
            if not self._is_skipping:
                lines.append(bytes(self._rest))
            self._rest, self._is_skipping = bytearray(), False
            self._append(part, lines)
        return lines

    def _append(self, part: bytes, lines: list[bytes]) -> None:
        """Add a part to the current line; if that becomes too long, add its stand-in to `lines`."""
        if self._is_skipping:
            return
        self._rest += part
        if len(self._rest) > MAX_LINE:
            head = bytes(self._rest[:MAX_LINE])
            lines.append(head if is_stop(head) else TOO_LONG)
            self._rest, self._is_skipping = bytearray(), True


class TypedLine(NamedTuple):
    """A line to be carried out; never a STOP."""

    text: str  # Without its end; empty if it has a fault.
    stops_before: int  # STOPs that had been read when it was read.
    fault: str = ""  # Why it cannot be carried out.


class Input:
    """A file descriptor that is read on a thread of its own, which counts the STOPs in it.

    STOPs are counted as they are read, since the loop may be busy; other lines wait until they are
    taken, each with the number of STOPs before it. While too many wait, further lines are dropped;
    a STOP never is. Blank lines are dropped unless a person types.
    """

    def __init__(
        self,
        descriptor: int | None,
        stops: Stops,
        clock: Clock,
        on_input: Callable[[], None],
        on_stop: Callable[[int], None],
    ) -> None:
        """Create the input; `on_input` is called on the running loop after something was read.

        `on_stop` is called at once, on the thread, with the number of each STOP by `Stops.count`.
        """
        self._descriptor, self._stops, self._clock = descriptor, stops, clock
        self._on_input, self._on_stop = on_input, on_stop
        self.last_line_timing = 0.0, 0.0  # Monotonic s of the last line, and since the one before.
        self._loop = asyncio.get_running_loop()
        self.is_terminal = descriptor is not None and os.isatty(descriptor)
        self._thread = threading.Thread(target=self._read, name="stdin", daemon=True)
        self._lock = threading.Lock()  # Held while the three attributes below are used.
        self._waiting: deque[tuple[bytes, int]] = deque()  # Each with the STOPs before it.
        self._size = 0  # Bytes of the waiting lines.
        self._is_full = False
        self._is_announced = False  # The loop will call `on_input`, and has not done so yet.
        self._is_closed = False
        self._is_at_work = False  # The thread has read something that is not counted or kept yet.
        self.has_ended = False
        # STOPs by `Stops.count`; whoever gets their answers removes them.
        self.unanswered: deque[int] = deque()
        self.overflows = 0  # Times that lines began to be dropped.

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """Ignore whatever is read from now on, a STOP too; the descriptor stays open.

        Lines that wait can still be taken. An unfinished line still counts, as a line or a STOP,
        after the thread's next read.
        """
        self._is_closed = True

    @property
    def is_reading(self) -> bool:
        """True from `start()` to the end of the input, or to the next read after `close()`."""
        return self._thread.is_alive()

    @property
    def has_line_or_end(self) -> bool:
        return bool(self._waiting) or self.has_ended

    @property
    def is_cancel_next(self) -> bool:
        """True if the line that has waited longest is `cancel`, without further words."""
        with self._lock:
            return bool(self._waiting) and self._waiting[0][0].split() == [b"cancel"]

    @property
    def is_quiet(self) -> bool:
        """True if nothing can be read now, and all that was read is counted or can be taken.

        Always True on Windows, and after `close()` or the end of the input.
        """
        if self._descriptor is None or self.has_ended or self._is_closed:
            return True
        if sys.platform == "win32":  # Windows can `select` sockets only.
            return True
        # The order matters: the thread marks itself at work before it takes bytes away.
        return not select.select([self._descriptor], [], [], 0)[0] and not self._is_at_work

    def take(self) -> TypedLine | None:
        """Remove and return the line that has waited longest; None if no line waits."""
        with self._lock:
            if not self._waiting:
                return None
            text, stops = self._waiting.popleft()
            self._size -= len(text)
            # Refusing ends when half has been taken, so that it is reported once, not per line.
            is_half = self._size <= MAX_WAITING // 2 and len(self._waiting) <= MAX_LINES // 2
            self._is_full = self._is_full and not is_half
        if text == TOO_LONG:
            return TypedLine("", stops, f"a line of more than {MAX_LINE} bytes")
        try:
            return TypedLine(text.decode(), stops)
        except UnicodeDecodeError:  # Replacement characters must not be sent to the robot.
            shown = text[:_SHOWN].decode(errors="replace")
            return TypedLine("", stops, f"a line that is not UTF-8: {shown}")

    # Called on the thread.

    def _read(self) -> None:
        splitter = LineSplitter()
        while (chunk := self._read_chunk()) and not self._is_closed:
            lines = splitter.feed(chunk)
            for _ in lines:
                now = self._clock.monotonic()
                self.last_line_timing = now, now - self.last_line_timing[0]
            self._keep(lines)
            self._is_at_work = False
            self._announce()
        self._keep(splitter.feed(b"\n"))  # The last line may have no end.
        self.has_ended = True
        self._announce()

    def _read_chunk(self) -> bytes:
        """Wait for input; b"" at the end.

        The caller clears `_is_at_work` once the bytes are kept.
        """
        while self._descriptor is not None:
            try:
                if sys.platform != "win32":
                    select.select([self._descriptor], [], [])
                self._is_at_work = True
                return os.read(self._descriptor, _CHUNK)
            # Another process that shares the descriptor made it non-blocking, and read first.
            except BlockingIOError:
                self._is_at_work = False
            except OSError:
                break
        return b""

    def _keep(self, lines: list[bytes]) -> None:
        """Count each line that is a STOP or calls its service; keep each other line.

        Each STOP is counted before a line that was read with it can be taken. Once too many lines
        wait, further ones are dropped until half of them are taken.
        """
        stops, kept = self._stops.count, list[tuple[bytes, int]]()
        for line in lines:
            if is_stop(line) or (b"call" in line and self._stops.is_stop_call(shell_words(line))):
                stops = self._stops.register()
                self.unanswered.append(stops)
                self._on_stop(stops)
            elif line.strip() or line == TOO_LONG or self.is_terminal:  # There, it is an answer.
                kept.append((line, stops))
        with self._lock:
            for line, stops in kept:
                is_over = self._size + len(line) > MAX_WAITING or len(self._waiting) >= MAX_LINES
                if not self._is_full and is_over:
                    self._is_full = True
                    self.overflows += 1
                if not self._is_full:
                    self._waiting.append((line, stops))
                    self._size += len(line)

    def _announce(self) -> None:
        """Have the loop call `on_input`, unless a call is due already."""
        if not self._is_announced:
            self._is_announced = True
            with contextlib.suppress(RuntimeError):  # The loop is closed: nobody waits for input.
                self._loop.call_soon_threadsafe(self._call_on_input)

    # Called on the loop.

    def _call_on_input(self) -> None:
        self._is_announced = False
        self._on_input()
