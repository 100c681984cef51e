"""The base of the app for everything that concerns the terminal, from its driver to its end."""

from __future__ import annotations

import asyncio
import contextvars
import gc
import sys
import threading
import traceback
from collections.abc import Callable, Coroutine, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from rich.console import RenderableType
from rich.segment import Segment
from textual import events
from textual._context import message_hook
from textual._styles_cache import StylesCache
from textual.app import App
from textual.color import Color
from textual.dom import DOMNode
from textual.driver import Driver
from textual.filter import LineFilter
from textual.message import Message
from textual.timer import Timer, TimerCallback
from textual.worker import Worker, WorkerFailed

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.imports import OF_ALL, OF_THE_SCREEN, import_the_rest
from archo_tui.base.safe_text import safe_in_place
from archo_tui.base.system import HANG_UP
from archo_tui.robot.stop.gate import Stops
from archo_tui.screen.terminal.ascii import ascii_only, in_ascii
from archo_tui.screen.terminal.stop_marks import stops_before
from archo_tui.screen.terminal.themes import (
    HIGH_CONTRAST,
    THEMES,
    TONES_OF_16_COLOURS,
    derive_tones,
    remember_theme,
    to_grey,
)
from archo_tui.station.alarms import Alarm
from archo_tui.station.shutdown import Shutdown
from archo_tui.station.station import Station

COMMANDS = "commands"  # The group of workers for which the end waits.
_SETTLE_TIME = 1.0  # Seconds in which the first screen is complete.


def start_worker(node: DOMNode, work: Callable[[], Coroutine[Any, Any, None]], group: str) -> None:
    """Run a coroutine as a Textual worker, without ending the others of its group.

    `work` is called when the worker begins: a coroutine of a worker that is cancelled before would
    never be awaited, which Python warns of.
    """
    node.run_worker(work, group=group)  # type: ignore[arg-type]  # its union takes any result


class TextFilter(LineFilter):
    """A filter that passes every text that is drawn through a function that keeps its width."""

    def __init__(self, change: Callable[[str], str]) -> None:
        super().__init__()
        self._change = change

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        return [
            segment if segment.control else Segment(self._change(segment.text), segment.style)
            for segment in segments
        ]


def _import_and_freeze() -> None:
    """Import all that the first picture did without, freeze it, and turn on the collector."""
    try:
        import_the_rest((*OF_ALL, *OF_THE_SCREEN))
    finally:
        gc.freeze()
        gc.enable()


# Textual 8.2.8 caches it with the instance among its arguments: the last 1,024 instances stay in
# memory, each with all the lines of a widget, 0.3 MB for each time that a palette is opened.
_original: Any = StylesCache.get_inner_outer


def _share_colour_cache() -> None:
    """Patch Textual to cache a widget's two colours by its arguments, not by the instance."""
    colours: Any = lru_cache(1024)(_original.__wrapped__)
    StylesCache.get_inner_outer = classmethod(colours)  # type: ignore[assignment]


class TerminalApp(App[None]):
    """The base of the console's app: driver, colours, STOP, the bell, and the end of the app."""

    _main_loop: asyncio.AbstractEventLoop

    def __init__(self, station: Station, theme: str) -> None:
        """Create the app; without a theme, it takes the one that suits the terminal's colours."""
        _share_colour_cache()
        super().__init__()
        self.station = station
        self.failure = ""  # The traceback that ended this screen.
        self.stop_key = ""  # Textual's name of the key.
        self.terminal: Any = None  # A SteadyDriver; none on Windows, or in a test.
        self.settings_before: Sequence[Any] | None = None  # For the end; None: those of the start.
        self.has_lent_terminal = False  # That of a console, which follows.
        self.is_followed = False  # After a crash another screen reads what is typed meanwhile.
        self._is_ending = False
        self._stop_context = contextvars.Context()  # STOP runs in it, outside of the app's queue.
        self._ending = Shutdown(
            station.robot,
            station.clock,
            station.on_disconnect,
            lambda code: self.end(code),
            self.wait_for_answers,
        )
        changes = [safe_in_place, in_ascii] if ascii_only() else [safe_in_place]
        self._text_filters = [TextFilter(change) for change in changes]
        for own in THEMES:
            self.register_theme(own)
        if theme or self.console.color_system == "standard":  # 16 colours have no tones.
            self.theme = theme or HIGH_CONTRAST.name

    def get_driver_class(self) -> type[Driver]:
        chosen = super().get_driver_class()
        # Tests have drivers of their own.
        if sys.platform != "win32" and chosen.__name__ == "LinuxDriver":
            from archo_tui.screen.terminal.driver import SteadyDriver

            return SteadyDriver
        return chosen

    def get_css_variables(self) -> dict[str, str]:
        """Return the theme's colours and derived tones, adapted to the terminal's colours."""
        variables = super().get_css_variables()
        if self.console.color_system == "256":
            variables |= to_grey(variables)
        if self.console.color_system == "standard" and self.theme == HIGH_CONTRAST.name:
            variables |= TONES_OF_16_COLOURS
        self.theme_variables = {**derive_tones(variables), **variables}
        return self.theme_variables

    def get_line_filters(self) -> Sequence[LineFilter]:
        return [*super().get_line_filters(), *self._text_filters]

    @property
    def is_ending(self) -> bool:
        """True once the end has begun, whose first part waits for the answers of commands."""
        return self._is_ending or self._ending.has_begun

    @property
    def unanswered(self) -> list[Worker[Any]]:
        """The workers of commands that have not ended yet."""
        return [w for w in self.workers if w.group == COMMANDS and not w.is_finished]

    async def wait_for_answers(self) -> None:
        """Wait until every command has ended, those given meanwhile included; ignore errors."""
        while given := [worker.wait() for worker in self.unanswered]:
            await asyncio.gather(*given, return_exceptions=True)

    def on_load(self) -> None:
        self._main_loop = asyncio.get_running_loop()
        message_hook.set(self._carry_stops)  # Before the tasks of widgets, which inherit it.
        self._stop_context = contextvars.copy_context()

    def _carry_stops(self, message: Message) -> None:
        """Set, for a message's handlers, how many STOPs had been read when its cause was typed."""
        self.stops.set_typed_at(stops_before(message))

    @property
    def stops(self) -> Stops:
        return self.station.robot.stops

    def is_stop(self, message: Message) -> bool:
        """Return True if a message is the key of STOP. Any thread."""
        return isinstance(message, events.Key) and message.key == self.stop_key

    def stop_typed(self, message: Message) -> None:
        """Call `stop_now` for the key of STOP, before any key that waits; an error ends the screen.

        The driver calls it on the event loop.
        """
        if isinstance(message, events.Key):
            try:
                self._stop_context.run(self.stop_now, message)
            except Exception as error:  # Outside of Textual's queue nobody else handles it.
                self._handle_exception(error)

    def before_suspend(self) -> None:
        """End what this console publishes: a process that is suspended reads no STOP.

        In a terminal that was lent, what is typed from now on is for its owner.
        """
        if self.has_lent_terminal:
            self.keep_keys()
        self.station.robot.end_publications_now()

    def stop_now(self, event: events.Key) -> None:
        """Stop the robot, because the key of STOP was pressed; a subclass has to define it."""
        raise NotImplementedError

    def on_mount(self) -> None:
        if not self.is_headless:
            self._ending.begin_on_signals()
        self.app_resume_signal.subscribe(self, lambda _: self.repaint())
        if not gc.isenabled():
            settle = threading.Thread(target=_import_and_freeze, name="imports", daemon=True)
            self.set_timer(_SETTLE_TIME, settle.start)

    def watch_theme(self, before: str, theme: str) -> None:
        """Write a theme that the operator chose to the disk, on a thread, for the next start."""

        async def write() -> None:
            try:
                # The last choice, not this one.
                await in_daemon(lambda: remember_theme(self.theme))
            except OSError as error:
                self.notify(f"cannot remember the theme: {error.strerror}", markup=False)

        if self.screen_stack and self.screen.is_mounted and before != theme:
            start_worker(self, write, COMMANDS)

    def ring(self, alarms: Iterable[Alarm]) -> None:
        """Ring the bell for new alarms of high priority, unless quiet; later if it is lent."""
        if self.terminal is not None and self.terminal.is_lent:
            return
        if self.station.bell.take_new(alarms) and not self.station.quiet:
            self.bell()

    def repaint(self) -> None:
        """Draw the whole screen again, since the terminal may show something else."""
        if self.is_running and self.screen_stack:
            self.screen.refresh(layout=True)
            self.refresh()

    @property
    def is_stuck(self) -> bool:
        """True while the terminal does not show what was drawn; False if nobody can tell."""
        return self.terminal is not None and bool(self.terminal.is_stuck)

    def on_paste_stalled(self) -> None:
        text = "The paste has not ended: what you type is added to it. Press escape to end it."
        self.notify(text, severity="warning", markup=False)

    def on_paste_cut(self) -> None:
        text = "The paste was cut off: nothing of it was taken. Paste it again."
        self.notify(text, severity="warning", markup=False)

    def set_timer(
        self,
        delay: float,
        callback: TimerCallback | None = None,
        *,
        name: str | None = None,
        pause: bool = False,
    ) -> Timer:
        """Call a function once after a delay in seconds, even if the machine is busy then.

        Textual's timer skips its only turn if the delay is over before its task runs at first.
        Textual lays out all screens for a new size of the terminal by a timer of 8 ms, so a busy
        machine lost that size for ever.
        """
        timer = super().set_timer(delay, callback, name=name, pause=pause)
        timer._skip = False
        return timer

    def keep_keys(self) -> None:
        """Leave the terminal raw at the end, and what is typed from now on to who follows."""
        if self.terminal is not None:
            self.settings_before = self.terminal.keep_keys() or self.settings_before

    @contextmanager
    def lend_terminal(self) -> Iterator[None]:
        """Leave the terminal to another program meanwhile, with what is typed from now on."""
        self.keep_keys()
        self.terminal.suspend_application_mode()
        self.terminal.is_lent = True
        try:
            yield
        finally:
            self.terminal.is_lent = False
            if not self._is_ending:
                self.terminal.resume_application_mode()
                self.repaint()

    def exit(
        self, result: None = None, return_code: int = 0, message: RenderableType | None = None
    ) -> None:
        self._is_ending = True
        if self.has_lent_terminal:
            self.keep_keys()
        super().exit(result, return_code, message)

    def end(self, code: int) -> None:
        self.exit(return_code=code)

    def hang_up(self) -> None:
        """Begin to end the app, because the terminal is gone."""
        self._ending.begin(HANG_UP)

    def _handle_exception(self, error: Exception) -> None:
        """Keep the traceback in `failure`, and end the screen without Textual's report.

        The first error counts. Without a terminal, as in a test, Textual handles the error itself.
        """
        if isinstance(error, WorkerFailed):  # The error that the worker raised is of interest.
            error = error.error if isinstance(error.error, Exception) else error
        if self.is_headless:
            super()._handle_exception(error)  # Makes the test fail.
            return
        if self._is_ending:  # Errors while the screen is taken down do not matter.
            return
        if not self.failure:
            self.failure = "".join(traceback.format_exception(error))
            if self.is_followed:
                self.keep_keys()  # A STOP that is typed before the next screen comes is for that.
        self.exit(return_code=1)
