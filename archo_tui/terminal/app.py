"""What the console owes its terminal: driver, ASCII, themes, signals, a screen that may crash."""

from __future__ import annotations

import asyncio
import contextvars
import gc
import sys
import threading
import traceback
from collections.abc import Callable, Coroutine, Iterable, Sequence
from typing import Any

from rich.segment import Segment
from textual import events
from textual._context import message_hook
from textual.app import App
from textual.color import Color
from textual.dom import DOMNode
from textual.driver import Driver
from textual.filter import LineFilter
from textual.message import Message
from textual.worker import Worker, WorkerFailed

from archo_tui.daemon_threads import in_daemon
from archo_tui.imports import OF_ALL, OF_THE_SCREEN, import_the_rest
from archo_tui.robot.stops import Stops
from archo_tui.robot.text import safe_in_place
from archo_tui.shutdown import RESTART, Shutdown
from archo_tui.station.alarms import Alarm
from archo_tui.station.station import Station
from archo_tui.system import HANG_UP
from archo_tui.terminal.ascii import ascii_only, in_ascii
from archo_tui.terminal.notice import notice
from archo_tui.terminal.styles_cache import share_colours
from archo_tui.terminal.themes import HIGH_CONTRAST, OF_16, THEMES, grey, remember, tones
from archo_tui.terminal.typed import typed_after

COMMANDS = "commands"  # the group of workers that the end waits for
_STANDS = 1.0  # s after which a screen is made


def begin(node: DOMNode, work: Callable[[], Coroutine[Any, Any, None]], group: str) -> None:
    """Have Textual run a worker; of one that is cancelled before its turn nothing was made yet.

    A coroutine that nobody awaits would be a warning, and end a test.
    """
    node.run_worker(work, group=group)  # type: ignore[arg-type]  # its union takes any result


class TextFilter(LineFilter):
    """Changes the text of whatever is drawn; its cells stay as many."""

    def __init__(self, change: Callable[[str], str]) -> None:
        super().__init__()
        self._change = change

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        return [
            segment if segment.control else Segment(self._change(segment.text), segment.style)
            for segment in segments
        ]


def _settle() -> None:
    """The screen stands: import the rest, then look for garbage.

    What was made so far stays, and is not looked through again and again.
    """
    try:
        import_the_rest((*OF_ALL, *OF_THE_SCREEN))
    finally:
        gc.freeze()
        gc.enable()


class TerminalApp(App[None]):
    """Base of the app."""

    _runs_on: asyncio.AbstractEventLoop

    def __init__(self, station: Station, theme: str) -> None:
        """`theme` is a name, or empty for the one that suits the terminal."""
        share_colours()
        super().__init__()
        self.station = station
        self.failure = ""  # the traceback that ended this screen
        self.stop_key = ""  # Textual's name of it
        self._beside = contextvars.Context()  # for what does not wait in the app's queue
        self._ending = Shutdown(
            station.robot,
            station.clock,
            station.on_disconnect,
            lambda code: self.exit(return_code=code),
            self.answers,
        )
        changes = [safe_in_place, in_ascii] if ascii_only() else [safe_in_place]
        self._of_text = [TextFilter(change) for change in changes]
        for own in THEMES:
            self.register_theme(own)
        if theme or self.console.color_system == "standard":  # 16 colours: none in between
            self.theme = theme or HIGH_CONTRAST.name

    def get_driver_class(self) -> type[Driver]:
        chosen = super().get_driver_class()
        if sys.platform != "win32" and chosen.__name__ == "LinuxDriver":  # else a test's
            from archo_tui.terminal.driver import SteadyDriver

            return SteadyDriver
        return chosen

    def get_css_variables(self) -> dict[str, str]:
        """The theme's, and tones between its colours, where it has none of its own."""
        variables = super().get_css_variables()
        if self.console.color_system == "256":
            variables |= grey(variables)
        if self.console.color_system == "standard" and self.theme == HIGH_CONTRAST.name:
            variables |= OF_16
        self.theme_variables = {**tones(variables), **variables}
        return self.theme_variables

    def get_line_filters(self) -> Sequence[LineFilter]:
        return [*super().get_line_filters(), *self._of_text]

    @property
    def unanswered(self) -> list[Worker[Any]]:
        """The commands that were given and have no answer yet."""
        return [w for w in self.workers if w.group == COMMANDS and not w.is_finished]

    async def answers(self) -> None:
        """Wait for them, and for those that are given meanwhile."""
        while given := [worker.wait() for worker in self.unanswered]:
            await asyncio.gather(*given, return_exceptions=True)

    def on_load(self) -> None:
        self._runs_on = asyncio.get_running_loop()
        message_hook.set(self._carry)  # before the tasks of all widgets, which take it along
        self._beside = contextvars.copy_context()

    def _carry(self, message: Message) -> None:
        """What a widget does because of a message comes from what was typed for it."""
        self.stops.set(typed_after(message))

    @property
    def stops(self) -> Stops:
        """Counts the STOPs that are read."""
        return self.station.robot.stops

    def is_stop(self, message: Message) -> bool:
        """True for the key of STOP; from any thread."""
        return isinstance(message, events.Key) and message.key == self.stop_key

    def stop_typed(self, message: Message) -> None:
        """Called on the loop by the driver: STOP jumps every queue."""
        if isinstance(message, events.Key):
            try:
                self._beside.run(self.stop_now, message)
            except Exception as error:  # Textual would not hear of it
                self._handle_exception(error)

    def stop_now(self, event: events.Key) -> None:
        """The key of STOP was pressed."""
        raise NotImplementedError

    def on_mount(self) -> None:
        if not self.is_headless:
            self._ending.on_signals()
        self.app_resume_signal.subscribe(self, lambda _: self.repaint())
        if not gc.isenabled():
            settle = threading.Thread(target=_settle, name="imports", daemon=True)
            self.set_timer(_STANDS, settle.start)

    def watch_theme(self, before: str, theme: str) -> None:
        """Remember a theme that the operator chose."""

        async def write() -> None:
            try:
                await in_daemon(lambda: remember(self.theme))  # the last, whichever ends last
            except OSError as error:
                self.notify(f"cannot remember the theme: {error.strerror}", markup=False)

        if self.screen_stack and self.screen.is_mounted and before != theme:
            begin(self, write, COMMANDS)

    def ring(self, alarms: Iterable[Alarm]) -> None:
        """Tell of grave alarms that are new, also somebody who looks elsewhere."""
        news = self.station.ringer.news(alarms)
        if news and not self.station.quiet and self._driver is not None:
            self.bell()
            self._driver.write("".join(notice(alarm.text) for alarm in news))

    def repaint(self) -> None:
        """Draw everything again: the terminal may show something else."""
        if self.is_running and self.screen_stack:
            self.screen.refresh(layout=True)
            self.refresh()

    @property
    def is_stuck(self) -> bool:
        """True while the terminal does not show what was drawn; another driver cannot tell."""
        return getattr(self._driver, "is_stuck", False)

    def on_paste_stalled(self) -> None:
        text = "The paste has not ended: what you type is added to it. Press escape to end it."
        self.notify(text, severity="warning", markup=False)

    def on_paste_cut(self) -> None:
        text = "The paste was cut off: nothing of it was taken. Paste it again."
        self.notify(text, severity="warning", markup=False)

    def restart(self, why: str) -> None:
        """End, and begin again with the same words; from any thread, once it is mounted."""
        self.station.robot.note("YOU", "console", f"{why}: all nodes restart")
        self._runs_on.call_soon_threadsafe(self._ending.begin, RESTART)

    def hang_up(self) -> None:
        """The terminal is gone."""
        self._ending.begin(HANG_UP)

    def _handle_exception(self, error: Exception) -> None:
        """Textual's end of the screen, without its report: the next screen shows it."""
        if isinstance(error, WorkerFailed):  # of any worker: what it raised is what is of interest
            error = error.error if isinstance(error.error, Exception) else error
        if self.is_headless:
            super()._handle_exception(error)  # so that tests fail
            return
        if self._exit:  # what is raised while the screen is taken down does not matter
            return
        self.failure = self.failure or "".join(traceback.format_exception(error))
        self._return_code = 1
        self._close_messages_no_wait()
