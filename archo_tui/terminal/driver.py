"""Textual's driver for terminals that stop reading, hang up, or are continued without a stop.

As it comes (Textual 8.2.8) LinuxDriver hands 30 writes to its output thread and then blocks the
event loop (textual/drivers/_writer_thread.py, a Queue with a bound); a terminal that is gone kills
that thread, and the loop waits for ever; a SIGCONT without a stop starts everything a second time;
an input at its end is read in a loop. See Textualize/textual#4104 for what it does about SIGTTOU.
Tested against the pinned version in tests/terminal/test_terminal.py.
"""

from __future__ import annotations

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

from textual import constants
from textual.drivers.linux_driver import LinuxDriver
from textual.message import Message

from archo_tui.terminal.keyboard import Keyboard
from archo_tui.terminal.typed import KnowsStop, hand_on

assert sys.platform != "win32"  # Textual's own driver serves there

MAX_WAITING = 64 * 1024  # bytes, or two frames of a large terminal; one of 160 x 48 has 20,000
_MARKS = 4096  # bytes of what stands around a frame
_STUCK = 0.5  # s after which a terminal that takes nothing is not seen to show what was drawn
_STOP_TIMEOUT = 0.5  # s that the end waits for a terminal that does not read
_READ = 64 * 1024  # bytes that are read before they are handed on: some thousand mouse moves
_POLL, _POLL_SOON = 0.1, 0.03  # s; soon while an escape may be a key
_ALTERNATE_KEYS = "\x1b[=4;2u"  # added to what Textual asks of kitty's protocol, and ends with it


class SteadyApp(KnowsStop, Protocol):
    """What the driver asks and tells the app."""

    stop_key: str  # Textual's name of it

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
        self._moved = 0.0  # when it began to write what it writes now, monotonic s

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

    @property
    def is_stuck(self) -> bool:
        """True while the terminal takes nothing, or something was dropped that it has not shown."""
        with self._changed:
            waits = self._writing and time.monotonic() - self._moved >= _STUCK
            return self._dropping or waits

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
                self._writing, self._moved = True, time.monotonic()
            try:
                while data:
                    self._moved = time.monotonic()
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
        if not constants.DISABLE_KITTY_KEY:
            self.write(_ALTERNATE_KEYS)
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

    @property
    def is_stuck(self) -> bool:
        """True while what was drawn last is not on the terminal."""
        return self._writer is not None and self._writer.is_stuck

    def _sigcont_application(self, *_: Any) -> None:
        if self._auto_restart and not self._started:
            self.resume_application_mode()

    def run_input_thread(self) -> None:
        """Read keys until told to end, or until there is nothing to read from any more."""
        app = cast(SteadyApp, self._app)
        keyboard = Keyboard(app.stop_key, self._debug)
        with selectors.SelectSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            while not self.exit_event.is_set():
                if selector.select(_POLL_SOON if keyboard.waiting else _POLL):
                    data = self._read(selector)
                    if not data:
                        self._dead()
                        return
                    messages = keyboard.take(data, time.monotonic())
                else:
                    messages = keyboard.late(time.monotonic())
                hand_on(messages, app, self._stop, self.process_message)

    def _stop(self, message: Message) -> None:
        self._tell(partial(cast(SteadyApp, self._app).stop_typed, message))

    def _read(self, selector: selectors.BaseSelector) -> bytes:
        """All that is there, within bounds; a terminal hands out a few thousand bytes at once."""
        data = b""
        with contextlib.suppress(OSError):
            while part := os.read(self.fileno, _READ - len(data)):
                data += part
                if len(data) == _READ or not selector.select(0):
                    break
        return data

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
