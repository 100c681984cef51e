"""A driver for terminals that stop reading, hang up, or are continued without a stop.

Textual's own LinuxDriver (8.2.8) hands 30 writes to its output thread and then blocks the event
loop (textual/drivers/_writer_thread.py, a Queue with a bound). A terminal that is gone ends that
thread, and the loop waits for ever. A SIGCONT without a stop starts everything a second time; an
input at its end is read in a loop. See Textualize/textual#4104 for what it does about SIGTTOU.
Tested against the pinned version in tests/terminal/test_terminal.py.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import selectors
import signal
import sys
import termios
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, Protocol

from textual import constants
from textual.drivers.linux_driver import LinuxDriver
from textual.events import Key
from textual.message import Message

from archo_tui.screen.terminal.keyboard import Keyboard
from archo_tui.screen.terminal.stop_marks import StopKeyOwner, dispatch

assert sys.platform != "win32"  # Textual's own driver serves on Windows.

MAX_WAITING = 64 * 1024  # Bytes; a frame of 160 x 48 cells has 20,000.
_FRAME_MARKS = 4096  # Bytes of the sequences around a frame.
_STUCK_AFTER = 0.5  # Seconds of one write after which the terminal counts as stuck.
_STOP_TIMEOUT = 0.5  # Seconds that the end waits for a terminal that does not read.
_MAX_READ = 64 * 1024  # Bytes, or some thousand mouse moves.
_POLL, _POLL_FOR_ESCAPE = 0.1, 0.03  # Seconds; shorter while an escape may be a key.
# Of kitty's protocol, in place of Textual's flags: unambiguous keys, and alternate ones, which tell
# ctrl+x under any layout. Text comes as text.
_NO_MOUSE = "\x1b[?1000l\x1b[?1003l\x1b[?1015l\x1b[?1006l"
_ALTERNATE_KEYS = "\x1b[<u\x1b[>5u"
# The second screen, no cursor, focus, mouse, marked pastes, no wrap: as Textual begins.
_MODES = (
    "\x1b[?1049h\x1b[?25l\x1b[?1004h\x1b[?1000h\x1b[?1003h\x1b[?1015h\x1b[?1006h\x1b[?2004h\x1b[?7l"
)


class DriverApp(StopKeyOwner, Protocol):
    """The methods of the app that the driver calls."""

    stop_key: str  # Textual's name of the key of STOP.
    settings_before: Sequence[Any] | None  # Of the terminal before the first start; None: as now.
    terminal: Any  # The driver, which sets it.

    def hang_up(self) -> None:
        """Begin to end the app, because the terminal is gone for good."""

    def repaint(self) -> None:
        """Draw everything again, because frames were dropped."""

    def before_suspend(self) -> None:
        """End what must not go on while this process is suspended."""

    def stop_typed(self, message: Message) -> None:
        """Stop the robot at once, before any key that waits."""

    def post_message(self, message: Message) -> bool:
        """Queue a message for the app; Textual's."""


class TerminalWriter(threading.Thread):
    """A thread that writes to a terminal at its pace, and drops frames that are too much for it."""

    def __init__(
        self, descriptor: int, on_drained: Callable[[], None], on_dead: Callable[[], None]
    ) -> None:
        """Create the thread; both functions are called on it, and the descriptor stays open.

        `on_drained` is called when everything is written after frames were dropped.
        """
        super().__init__(daemon=True, name="textual-output")
        self._descriptor = descriptor
        self._on_drained, self._on_dead = on_drained, on_dead
        self._waiting: deque[tuple[bytes, bool]] = deque()
        self._size = 0
        # The largest write so far: a frame of any size must fit, with the marks around it.
        self._largest_write = 0
        self._changed = threading.Condition()
        self._dropping = self._writing = self._ending = self.dead = False
        self._write_began = 0.0  # Monotonic time of the current write, in s.

    def write(self, text: str, *, keep: bool = False) -> None:
        """Queue a text for writing, without waiting; drop it if too much is queued already.

        All that is queued is dropped then, and so is what follows, until the terminal has taken the
        rest: only texts with `keep`, such as its modes, stay.
        """
        data = text.encode("utf-8", "replace")
        with self._changed:
            if self.dead or (self._dropping and not keep):
                return
            self._largest_write = max(self._largest_write, len(data))
            if (
                self._size + len(data) > max(MAX_WAITING, 2 * self._largest_write + _FRAME_MARKS)
                and not keep
            ):
                self._dropping = True
                self._waiting = deque(item for item in self._waiting if item[1])
                self._size = sum(len(kept) for kept, _ in self._waiting)
                return
            self._waiting.append((data, keep))
            self._size += len(data)
            self._changed.notify_all()

    @property
    def is_stuck(self) -> bool:
        """True while a write takes 0.5 s or longer, or dropped frames await a redraw."""
        with self._changed:
            waits = self._writing and time.monotonic() - self._write_began >= _STUCK_AFTER
            return self._dropping or waits

    def flush(self) -> None:
        """Do nothing: the thread writes as soon as it can. Textual calls it."""

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
                self._writing, self._write_began = True, time.monotonic()
            try:
                while data:
                    self._write_began = time.monotonic()
                    data = data[os.write(self._descriptor, data) :]
            except OSError:
                self.kill()
                self._on_dead()
                return

    def kill(self) -> None:
        """Drop what is queued, let the thread end, and queue nothing more."""
        with self._changed:
            self.dead = True
            self._waiting.clear()
            self._size = 0
            self._changed.notify_all()

    def stop(self) -> None:
        """Write what is queued, and end the thread.

        It waits for a terminal that does not read, 0.5 s twice at most, and drops the rest.
        """
        with self._changed:
            self._ending = True
            self._changed.notify_all()
            idle = self._changed.wait_for(
                lambda: self.dead or not (self._waiting or self._writing), _STOP_TIMEOUT
            )
        if not idle:  # Drop what the terminal has not taken, so that its modes can be restored.
            with contextlib.suppress(termios.error):
                termios.tcflush(self._descriptor, termios.TCOFLUSH)
        self.join(_STOP_TIMEOUT)


class SteadyDriver(LinuxDriver):
    """A driver that never blocks the event loop, and ends the app when the terminal is gone."""

    def __init__(self, app: Any, **options: Any) -> None:
        self._console: DriverApp = app
        app.terminal = self
        self._call_threadsafe = asyncio.get_running_loop().call_soon_threadsafe
        self._reader: threading.Thread | None = None
        self._writer: TerminalWriter | None = None
        self._started = False
        self._is_setting_modes = True  # Such writes are never dropped.
        self._keeps_keys = self.is_lent = False
        self._raw: Any = None  # The terminal's settings while this console reads it.
        self._empty_at = time.monotonic()  # In s: the last time when there was nothing to read.
        super().__init__(app, **options)

    # LinuxDriver creates its thread within start_application_mode; the setter replaces it.
    @property
    def _writer_thread(self) -> Any:
        return self._writer

    @_writer_thread.setter
    def _writer_thread(self, made: Any) -> None:
        if made is None:
            self._writer = None
        else:
            self._writer = TerminalWriter(made.fileno(), self._on_output_drained, self._on_hang_up)

    def start_application_mode(self) -> None:
        if self.is_lent:  # SIGCONT comes while another program draws, too.
            return
        if self._started:  # It was stopped by SIGSTOP, unasked.
            self._take_terminal_back()
            return
        self._is_setting_modes, self._keeps_keys = True, False
        # In the background Textual returns without starting, and without a writer.
        super().start_application_mode()  # type: ignore[no-untyped-call]
        before = self._console.settings_before
        self.attrs_before = self.attrs_before if before is None else [*before]
        if not constants.DISABLE_KITTY_KEY:
            self.write(_ALTERNATE_KEYS)
        self._started, self._is_setting_modes = self._writer is not None, False
        with contextlib.suppress(termios.error):
            self._raw = termios.tcgetattr(self.fileno)

    def _take_terminal_back(self) -> None:
        """Set the modes again, if a shell that ran meanwhile has left its own behind.

        With these, no key would be read before enter. In the background nothing is set.
        """
        try:
            is_ours = termios.tcgetattr(self.fileno) == self._raw
            if is_ours or os.tcgetpgrp(self.fileno) != os.getpgrp():
                return
            termios.tcsetattr(self.fileno, termios.TCSANOW, self._raw)
        except (OSError, termios.error):  # The terminal is gone.
            return
        self._is_setting_modes = True
        self.write(_MODES)
        if not constants.DISABLE_KITTY_KEY:
            self.write(_ALTERNATE_KEYS)
        self._is_setting_modes = False
        self._call_on_loop(self._console.repaint)

    def stop_application_mode(self) -> None:
        self._is_setting_modes = True
        super().stop_application_mode()
        self._started = False

    def keep_keys(self) -> list[Any] | None:
        """Read no more, and leave the terminal raw at the end: what is typed waits for who follows.

        Returns the settings from before the start, as numbers only, or None if they are not known.
        """
        self._keeps_keys = True
        self.exit_event.set()
        settings, self.attrs_before = self.attrs_before, None
        if settings is None:
            return None
        *numbers, characters = settings
        return [*numbers, [c if isinstance(c, int) else ord(c) for c in characters]]

    def disable_input(self) -> None:
        if not self._keeps_keys:
            super().disable_input()
            return
        # As Textual does it, but what waits to be read is not thrown away.
        signal.signal(signal.SIGWINCH, signal.SIG_DFL)
        self.write(_NO_MOUSE)
        if self._reader is not None:
            self._reader.join()
        self.exit_event.clear()

    def close(self) -> None:
        super().close()
        self._writer = None

    def write(self, data: str) -> None:
        if self._writer is not None:
            self._writer.write(data, keep=self._is_setting_modes)

    @property
    def is_stuck(self) -> bool:
        return self._writer is not None and self._writer.is_stuck

    def suspend_application_mode(self) -> None:
        self._console.before_suspend()
        super().suspend_application_mode()

    def run_input_thread(self) -> None:
        """Read keys until the driver ends or the terminal is gone, and pass on their messages.

        STOP overtakes the keys that were read with it. When the terminal is gone, the app is told
        to end.
        """
        app, self._reader = self._console, threading.current_thread()
        keyboard, began_at = Keyboard(app.stop_key), self._empty_at
        with selectors.SelectSelector() as selector:
            selector.register(self.fileno, selectors.EVENT_READ)
            while not self.exit_event.is_set():
                began, wait = time.monotonic(), _POLL_FOR_ESCAPE if keyboard.is_waiting else _POLL
                # What silence decides is as old as its first byte.
                began_at = began_at if keyboard.is_waiting else self._empty_at
                is_ready = selector.select(wait)
                if self.exit_event.is_set():
                    return
                if is_ready:
                    data = self._read_available(selector)
                    if not data:
                        self._on_hang_up()
                        return
                    messages = keyboard.feed(data, time.monotonic())
                else:
                    self._empty_at = began + wait
                    messages = keyboard.on_silence(time.monotonic())
                others: list[Message] = []
                dispatch(messages, app, self._on_stop_key, others.append, began_at)
                if others:
                    self._call_on_loop(partial(self._process_all, others))

    def _process_all(self, messages: Iterable[Message]) -> None:
        """Pass on messages in one step of the loop.

        Each step begun from another thread may wait for a busy loop, and a STOP behind them.
        """
        for message in messages:
            self.process_message(message)

    def send_message(self, message: Message) -> None:
        self._console.post_message(message)  # Textual's own begins a task for each message.

    def _on_stop_key(self, message: Message) -> None:
        self._call_on_loop(partial(self._console.stop_typed, message))

    def _read_available(self, selector: selectors.BaseSelector) -> bytes:
        """Return everything that can be read now; empty if the terminal is gone."""
        data = b""
        with contextlib.suppress(OSError):
            while part := os.read(self.fileno, _MAX_READ - len(data)):
                data += part
                now = time.monotonic()
                if len(data) == _MAX_READ:
                    break
                if not selector.select(0):
                    self._empty_at = now
                    break
        return data

    def _on_hang_up(self) -> None:
        self.exit_event.set()
        if self._writer is not None:
            self._writer.kill()
        self._call_on_loop(self._console.hang_up)

    def _on_output_drained(self) -> None:
        self.write("\x1b[?2026l")  # The end of a frame may have been dropped.
        self._call_on_loop(self._console.repaint)

    def _call_on_loop(self, function: Callable[[], None]) -> None:
        with contextlib.suppress(RuntimeError):  # The loop may be closed.
            self._call_threadsafe(function)


def drain_keys(descriptor: int, stop_key: str) -> set[str]:
    """Drop what was typed while no console read it; return Textual's names of the keys."""
    with selectors.DefaultSelector() as selector:
        selector.register(descriptor, selectors.EVENT_READ)
        typed = b""
        with contextlib.suppress(OSError):
            while selector.select(0) and (part := os.read(descriptor, _MAX_READ)):
                typed += part
    messages = Keyboard(stop_key).feed(typed, time.monotonic()) if typed else []
    return {message.key for message in messages if isinstance(message, Key)}
