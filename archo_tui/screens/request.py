"""What an assistant asks for, with how the robot is: a person allows it once, or denies it."""

from __future__ import annotations

import math
from collections.abc import Callable

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Button, Static

from archo_tui.robot.text import harmless
from archo_tui.robot.values import text_of
from archo_tui.screens.dialog import Dialog
from archo_tui.station.requests import READ, Request
from archo_tui.station.station import View
from archo_tui.terminal.typed import now, read_of
from archo_tui.words import spoken

APART = 0.3  # s that an answer comes behind the key before it, which a paste's does not


class AnswerRequest(Dialog[None]):
    """`Deny` has the focus; escape leaves the request as it is."""

    closes_at_stop = True

    BINDINGS = [
        ("escape,q", "close", "Answer later"),
        ("up,pageup", "scroll(-1)", "Up"),
        ("down,pagedown", "scroll(1)", "Down"),
        ("left", "app.focus_previous", "The answer before"),
        ("right", "app.focus_next", "The next answer"),
    ]

    def __init__(
        self,
        request: Request,
        view: View,
        answer: Callable[[int, bool], None],
        gone: Callable[[str], None],
    ) -> None:
        """`gone(why)` is called when the request is over before anybody has answered."""
        super().__init__()
        self._request, self._view = request, view
        self._answer, self._gone = answer, gone
        self._drawn = math.inf  # when it was, in s as messages have their time
        self._text = Static(classes="asked")

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = "An assistant asks"
            box.border_subtitle = "← → enter   esc later"
            with VerticalScroll(classes="question", can_focus=False):
                yield self._text
            with Horizontal(classes="answers"):
                yield Button("Deny", id="deny", compact=True)
                yield Button("Allow once", id="allow", compact=True)

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#deny"))
        self._write()
        self.call_after_refresh(self._now_drawn)

    def _now_drawn(self) -> None:
        self._drawn = now()

    def show(self, view: View) -> None:
        """So it is now; what waits no more is not answered."""
        self._view = view
        waits = any(one.number == self._request.number for one in view.requests)
        if not waits and not self.has_left:
            self._gone("The request is over")
            self.dismiss()
        elif waits:
            self._write()

    def _write(self) -> None:
        one, view = self._request, self._view
        values = [f"  {name}: {text_of(value)}" for name, value in one.goal.values.items()]
        lines = [
            f"{one.asker.source} wants: {one.text}",
            *values,
            "",
            f"battery: {spoken.battery(view.snapshot, view.now)}",
            f"robot: {spoken.motion(view.snapshot, view.now)}",
            f"expires in {one.left(view.now):.0f} s",
        ]
        self._text.update(Content("\n".join(map(harmless, lines))))

    def on_button_pressed(self, event: Button.Pressed) -> None:
        read = read_of(event)
        if read is None or read.at - self._drawn < READ or read.pause < APART:
            self.notify("Read it first, then answer.", severity="warning", markup=False)
            return
        self.dismiss()  # first: it is over by the answer then
        self._answer(self._request.number, event.button.id == "allow")

    def action_scroll(self, step: int) -> None:
        """Where not all of it has room."""
        box = self.query_one(VerticalScroll)
        box.scroll_relative(y=step * 3, animate=False)
