"""Panel 2: encoder, speed, stop."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.widgets import Button

from archo_tui import state_text
from archo_tui.robot.state import MOTOR, RESET, STOP
from archo_tui.station import View
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.styled import content


class MotorPanel(Panel, can_focus=True):
    """Live ticks and speed, and the two buttons, far apart."""

    number, title_text = 2, "Motor"
    keys = (("reset", "reset"), ("stop", "stop"), ("release", "release"))

    def __init__(self) -> None:
        super().__init__()
        self._line, self._word = Line(id="motor-line"), Line(id="motor-word")
        self.buttons = {
            RESET: Button("Reset encoder", id="reset", compact=True, action="app.command('reset')"),
            STOP: Button("STOP", id="stop", compact=True, action="app.command('stop')"),
        }

    def compose(self) -> ComposeResult:
        yield self._line
        yield self._word
        with Horizontal(classes="buttons"):
            yield self.buttons[RESET]
            yield Line(classes="gap")
            yield self.buttons[STOP]

    def show(self, view: View) -> None:
        self.show_publishers(view, MOTOR)
        self.show_keys(view)
        line = state_text.motor_line(view.snapshot, view.now)
        self._line.show(content(line))
        state = state_text.motor_word(view.snapshot, view.now, self._word.size.width)
        release = f" [@click=app.command('release')]({view.key('release')} releases)[/]"
        stopped = state == state_text.STOPPED
        hint = Content.from_markup(release) if stopped else Content("")
        self._word.show(Content.assemble(content(state), hint))
        self.grey(view, self.buttons)
