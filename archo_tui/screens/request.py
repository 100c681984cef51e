"""What an assistant asks for, with how the robot is: a person allows it once, or denies it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.events import Resize
from textual.widget import Widget
from textual.widgets import Static

from archo_tui.robot.text import harmless
from archo_tui.screens.dialog import Dialog
from archo_tui.station.requests import READ, Request, written
from archo_tui.station.station import View
from archo_tui.terminal.stop_marks import InputTime, now
from archo_tui.widgets.button import Button
from archo_tui.words import line_by_line

_AROUND = 5  # lines that are not the question: answers, borders, the keys below
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
        unseen: Callable[[], bool],
        read: Callable[[], InputTime | None],
        answer: Callable[[int, bool], None],
        gone: Callable[[str], None],
    ) -> None:
        """`unseen()` is true while the terminal does not show what was drawn.

        `read()` tells when the key or click that is being done was read.
        `gone(why)` is called when the request is over before anybody has answered.
        """
        super().__init__()
        self._request, self._view = request, view
        self._unseen, self._read, self._answer, self._gone = unseen, read, answer, gone
        self._drawn = math.inf  # when it was, in s as messages have their time
        self._text = Static(classes="asked")
        self._allow = Button("Allow once", partial(self._give, True), id="allow")

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = "An assistant asks"
            box.border_subtitle = "← → enter   esc later"
            with VerticalScroll(classes="question", can_focus=False):
                yield self._text
            with Horizontal(classes="answers"):
                yield Button("Deny", partial(self._give, False), id="deny")
                yield self._allow

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#deny"))
        self._write()
        self.app.app_resume_signal.subscribe(self, lambda _: self._draw_anew())

    def on_screen_resume(self) -> None:
        """In front, at first or again."""
        self._draw_anew()

    def on_resize(self, event: Resize) -> None:
        """The answers stay in view, and what is asked can be scrolled."""
        box = self.query_one(VerticalScroll)
        box.styles.max_height = max(event.size.height - _AROUND, 1)
        self._draw_anew()

    def _draw_anew(self) -> None:
        """It was away, or looks different now: it is read from here on."""
        self._drawn = math.inf
        self.call_after_refresh(self._now_drawn)

    def _now_drawn(self) -> None:
        self._drawn = now()

    def _is_in_view(self, part: Widget) -> bool:
        """True when its end is, where it is scrolled to."""
        place = self.find_widget(part)
        seen = place.visible_region
        return bool(seen) and seen.bottom_right == place.region.bottom_right

    def follow(self, view: View) -> None:
        """So it is now; what waits no more is not answered."""
        self._view = view
        waits = any(one.number == self._request.number for one in view.requests)
        if not waits and not self.has_left:
            self._gone("The request is over")
            self.dismiss()
        elif waits:
            self._write()
            if self._unseen():
                self._draw_anew()

    def _write(self) -> None:
        one, view = self._request, self._view
        values = [f"  {name}: {written(value)}" for name, value in one.goal.values.items()]
        lines = [
            f"{one.asker.source} wants: {one.text}",
            *values,
            "",
            f"battery: {line_by_line.battery_text(view.snapshot, view.now)}",
            f"robot: {line_by_line.motion_text(view.snapshot, view.now)}",
            f"expires in {one.left(view.now):.0f} s",
        ]
        self._text.update(Content("\n".join(map(harmless, lines))))

    def _give(self, is_allowed: bool) -> None:
        read = self._read()
        soon = read is None or read.at - self._drawn < READ or read.pause < APART
        if soon or self._unseen():
            self.notify("Read it first, then answer.", severity="warning", markup=False)
            return
        if is_allowed and not (self._is_in_view(self._text) and self._is_in_view(self._allow)):
            said = "Not all of it is seen: scroll by ↓, or make the terminal larger."
            self.notify(said, severity="warning", markup=False)
            return
        self.dismiss()  # first: it is over by the answer then
        self._answer(self._request.number, is_allowed)

    def action_scroll(self, step: int) -> None:
        """Where not all of it has room; no line is left out."""
        box = self.query_one(VerticalScroll)
        box.scroll_relative(y=step * min(3, max(box.size.height, 1)), animate=False)
