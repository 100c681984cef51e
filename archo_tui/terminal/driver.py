"""Textual's driver for terminals that stop reading, hang up, or are continued without a stop.

As it comes (Textual 8.2.8) LinuxDriver hands 30 writes to its output thread and then blocks the
event loop (textual/drivers/_writer_thread.py, a Queue with a bound); a terminal that is gone kills
that thread, and the loop waits for ever; a SIGCONT without a stop starts everything a second time;
an input at its end is read in a loop. See Textualize/textual#4104 for what it does about SIGTTOU.
Tested against the pinned version in tests/test_terminal.py.
"""

from __future__ import annotations

import codecs
import contextlib
import os
import selectors
import sys
import termios
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol, cast

from textual._xterm_parser import XTermParser
from textual.drivers.linux_driver import LinuxDriver
from textual.message import Message

from archo_tui.terminal.typed import Stopping, hand_on

assert sys.platform != "win32"  # Textual's own driver serves there

MAX_WAITING = 64 * 1024  # bytes, or two frames of a large terminal; one of 160 x 48 has 20,000
_MARKS = 4096  # bytes of what stands around a frame
_STOP_TIMEOUT = 0.5  # s that the end waits for a terminal that does not read
_MARKER_WAIT = 0.5  # s that the rest of a paste's marker is waited for, over a slow link
_PASTE_WAIT = 2.0  # s without input after which a paste is over whose end was lost
_PASTE_BEGIN, _PASTE_END = "\x1b[200~", "\x1b[201~"


class SteadyApp(Stopping, Protocol):
    """What the driver tells the app."""

    def hang_up(self) -> None:
        """The terminal is gone for good."""

    def repaint(self) -> None:
        """Frames were dropped: draw everything."""

    def stop_typed(self, message: Message) -> None:
        """STOP at once, before whatever else waits."""


class Writer(threading.Thread):
    """Writes to a terminal at its own pace. What is too much for it is dropped."""

    def __init__(
        self, descriptor: int, on_drained: Callable[[], None], on_dead: Callable[[], None]
    ) -> None:
        """`on_drained` is called when all is written after something was dropped."""
        super().__init__(daemon=True, name="textual-output")
        self._descriptor = descriptor
        self._on_drained, self._on_dead = on_drained, on_dead
        self._waiting: deque[tuple[bytes, bool]] = deque()
        self._size = 0
        self._largest = 0  # write so far: a frame of any size has room, and the marks around it
        self._changed = threading.Condition()
        self._dropping = self._writing = self._ending = self.dead = False

    def write(self, text: str, *, keep: bool = False) -> None:
        """Take text for writing; what is not to be dropped, like the terminal's modes, is kept."""
        data = text.encode("utf-8", "replace")
        with self._changed:
            if self.dead or (self._dropping and not keep):
                return
            self._largest = max(self._largest, len(data))
            if self._size + len(data) > max(MAX_WAITING, 2 * self._largest + _MARKS) and not keep:
                self._dropping = True
                self._waiting = deque(item for item in self._waiting if item[1])
                self._size = sum(len(kept) for kept, _ in self._waiting)
                return
            self._waiting.append((data, keep))
            self._size += len(data)
            self._changed.notify_all()

    def flush(self) -> None:
        """Everything is on its way already."""

    def run(self) -> None:
        while True:
            with self._changed:
                self._writing = False
                self._changed.notify_all()
                while not self._waiting:
                    if self._ending or self.dead:
                        return
                    if self._dropping:
                        self._dropping = False
                        self._on_drained()
                    self._changed.wait()
                data, _ = self._waiting.popleft()
                self._size -= len(data)
                self._writing = True
            try:
                while data:
                    data = data[os.write(self._descriptor, data) :]
            except OSError:
                self.kill()
                self._on_dead()
                return

    def kill(self) -> None:
        """Write nothing more."""
        with self._changed:
            self.dead = True
            self._waiting.clear()
            self._size = 0
            self._changed.notify_all()

    def stop(self) -> None:
        """Write what waits and end; a terminal that does not read is not waited for."""
        with self._changed:
            self._ending = True
            self._changed.notify_all()
            idle = self._changed.wait_for(
                lambda: self.dead or not (self._waiting or self._writing), _STOP_TIMEOUT
            )
        if not idle:  # what the terminal has not taken yet makes room for its modes
            with contextlib.suppress(termios.error):
                termios.tcflush(self._descriptor, termios.TCOFLUSH)
        self.join(_STOP_TIMEOUT)


class Markers:
    """Keeps the marks around a paste whole; without its begin a paste would be keys, STOP too."""

    def __init__(self) -> None:
        self._begun = ""  # what may be the first part of a mark
        self._pasting = False
        self._heard = 0.0  # monotonic s

    def take(self, text: str, now: float) -> str:
        """What was read: all but what may be a part of a mark."""
        self._heard = now
        text = self._begun + text
        lengths = range(len(_PASTE_BEGIN) - 1, 1, -1)  # escape alone is a key
        endings = (text[-length:] for length in lengths)
        marks = (_PASTE_BEGIN, _PASTE_END)
        self._begun = next((e for e in endings if any(m.startswith(e) for m in marks)), "")
        text = text[: len(text) - len(self._begun)]
        if _PASTE_BEGIN in text or _PASTE_END in text:
            self._pasting = text.rfind(_PASTE_BEGIN) > text.rfind(_PASTE_END)
        return text

    def late(self, now: float) -> str:
        """What to read while nothing comes: a part of a mark that was none, the lost end."""
        if self._begun and now - self._heard > _MARKER_WAIT:
            text, self._begun = self._begun, ""
            return text
        if self._pasting and now - self._heard > _PASTE_WAIT:
            self._pasting = False
            return _PASTE_END
        return ""


class SteadyDriver(LinuxDriver):
    """Never blocks the loop, and knows when the terminal is gone."""

    def __init__(self, *args: Any, **options: Any) -> None:
        self._writer: Writer | None = None
        self._started = False
        self._modes = True  # what is written now sets or restores the terminal's modes
        super().__init__(*args, **options)

    # LinuxDriver makes its own thread in the middle of start_application_mode
    @property
    def _writer_thread(self) -> Any:
        return self._writer

    @_writer_thread.setter
    def _writer_thread(self, made: Any) -> None:
        if made is None:
            self._writer = None
        else:
            self._writer = Writer(made.fileno(), self._drained, self._dead)

    def start_application_mode(self) -> None:
        if self._started:
            return
        self._modes = True
        # in the background it returns without having begun
        super().start_application_mode()  # type: ignore[no-untyped-call]
        self._started, self._modes = self._writer is not None, False

    def stop_application_mode(self) -> None:
        self._modes = True
        super().stop_application_mode()
        self._started = False

    def close(self) -> None:
        super().close()
        self._writer = None

    def write(self, data: str) -> None:
        if self._writer is not None:
            self._writer.write(data, keep=self._modes)

    def _sigcont_application(self, *_: Any) -> None:
        if self._auto_restart and not self._started:
            self.resume_application_mode()

    def run_input_thread(self) -> None:
        """Read keys until told to end, or until there is nothing to read from any more."""
        parser, marked = XTermParser(self._debug), Markers()
        app = cast(SteadyApp, self._app)
        decode = codecs.getincrementaldecoder("utf-8")(errors="replace").decode
        with selectors.SelectSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            while not self.exit_event.is_set():
                if selector.select(0.1):
                    data = self._read()
                    if not data:
                        self._dead()
                        return
                    text = marked.take(decode(data), time.monotonic())
                else:
                    text = marked.late(time.monotonic())
                # of nothing the parser would think that it is the end
                messages = [*(parser.feed(text) if text else ()), *parser.tick()]
                hand_on(messages, app, self._stop, self.process_message)

    def _stop(self, message: Message) -> None:
        self._tell(partial(cast(SteadyApp, self._app).stop_typed, message))

    def _read(self) -> bytes:
        try:
            return os.read(self.fileno, 4096)
        except OSError:
            return b""

    def _dead(self) -> None:
        self.exit_event.set()
        if self._writer is not None:
            self._writer.kill()
        self._tell(cast(SteadyApp, self._app).hang_up)

    def _drained(self) -> None:
        self.write("\x1b[?2026l")  # the end of a frame may be among what was dropped
        self._tell(cast(SteadyApp, self._app).repaint)

    def _tell(self, function: Callable[[], None]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(function)
