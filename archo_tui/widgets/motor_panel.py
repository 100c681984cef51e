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

    def compose(self) -> ComposeResult:
        yield Line(id="motor-line")
        yield Line(id="motor-word")
        with Horizontal(classes="buttons"):
            yield Button("Reset encoder", id="reset", compact=True, action="app.command('reset')")
            yield Line(classes="gap")
            yield Button("STOP", id="stop", compact=True, action="app.command('stop')")

    def show(self, view: View) -> None:
        self.show_publishers(view, MOTOR)
        self.show_keys(view)
        line = state_text.motor_line(view.snapshot, view.now)
        self.query_one("#motor-line", Line).show(content(line))
        word = self.query_one("#motor-word", Line)
        state = state_text.motor_word(view.snapshot, view.now, word.size.width)
        release = f" [@click=app.command('release')]({view.key('release')} releases)[/]"
        hint = Content.from_markup(release if state == state_text.STOPPED else "")
        word.show(Content.assemble(content(state), hint))
        self.grey(view, reset=RESET, stop=STOP)
