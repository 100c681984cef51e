"""The dialog in which a person allows or denies what an assistant requests."""

from __future__ import annotations

import math
from functools import partial

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.geometry import Size
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Static

from archo_tui.base.safe_text import harmless
from archo_tui.screen.commands.base import Desk
from archo_tui.screen.dialog import Dialog
from archo_tui.screen.widgets.field import Button
from archo_tui.station.approvals import READING_TIME, ApprovalRequest, quoted
from archo_tui.station.view import View
from archo_tui.text import line_by_line

# Seconds between an answer and the key before it; keys in a paste come faster.
MIN_PAUSE = 0.3


class AnswerRequest(Dialog):
    """The request of an assistant with the state of the robot; the person allows or denies it.

    `Deny` has the focus at first; escape answers nothing, and the request goes on waiting. An
    answer counts only if the request has been visible long enough to be read, and `Allow` only with
    all of it in sight. A STOP closes the dialog.
    """

    closes_at_stop = True

    BINDINGS = [
        ("escape,q", "close", "Answer later"),
        ("up,pageup", "scroll(-1)", "Up"),
        ("down,pagedown", "scroll(1)", "Down"),
        ("left", "app.focus_previous", "The answer before"),
        ("right", "app.focus_next", "The next answer"),
    ]

    def __init__(self, desk: Desk, request: ApprovalRequest) -> None:
        super().__init__()
        self._desk, self._request = desk, request
        self._drawn_at = math.inf  # Seconds on the clock of Textual's messages.
        self._drawn_size = Size()  # Of the question: a notice leaves it less room.
        self._text = Static(classes="asked")
        self._allow = Button("Allow once", partial(self._give_answer, True), id="allow")

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = "An assistant asks"
            box.border_subtitle = "← → enter   esc later"
            with VerticalScroll(classes="question", can_focus=False):
                yield self._text
            with Horizontal(classes="answers"):
                yield Button("Deny", partial(self._give_answer, False), id="deny")
                yield self._allow

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#deny"))
        self._show_request(self._desk.view)
        self.app.app_resume_signal.subscribe(self, lambda _: self._restart_reading())

    def on_unmount(self) -> None:
        # Textual keeps what it calls for a screen, and by that the screen.
        self.app.app_resume_signal.unsubscribe(self)

    def on_screen_resume(self, event: events.ScreenResume) -> None:
        """Restart the time for reading, since the dialog is in front, at first or again."""
        self._restart_reading()

    def on_resize(self) -> None:
        self._restart_reading()

    def _restart_reading(self) -> None:
        """Count the time for reading from the next drawing on; until then no answer counts."""
        self._drawn_at = math.inf
        self.call_after_refresh(self._set_drawn)

    def _set_drawn(self) -> None:
        self._drawn_at, self._drawn_size = Message().time, self._size_of_question

    @property
    def _size_of_question(self) -> Size:
        return self.query_one(VerticalScroll).size

    def _is_end_visible(self, widget: Widget) -> bool:
        geometry = self.find_widget(widget)
        visible = geometry.visible_region
        return bool(visible) and visible.bottom_right == geometry.region.bottom_right

    def show_view(self, view: View) -> None:
        """Show the state of the robot and how long the request waits; close once it is over.

        While the terminal does not show what was drawn, the time for reading begins anew.
        """
        is_waiting = any(waiting.number == self._request.number for waiting in view.requests)
        if not is_waiting and not self.is_dismissed:
            self._desk.drop_following_keys("The request is over")
            self.dismiss()
        elif is_waiting:
            self._show_request(view)
            if self._desk.is_stuck or self._size_of_question != self._drawn_size:
                self._restart_reading()

    def _show_request(self, view: View) -> None:
        request = self._request
        values = [f"  {name}: {quoted(value)}" for name, value in request.goal.values.items()]
        lines = [
            f"{request.requester.source} wants: {request.text}",
            *values,
            "",
            f"battery: {line_by_line.battery_text(view.snapshot, view.now)}",
            f"robot: {line_by_line.motion_text(view.snapshot, view.now)}",
            f"expires in {request.seconds_left(view.now):.0f} s",
        ]
        self._text.update(Content("\n".join(map(harmless, lines))))

    def _give_answer(self, is_allowed: bool) -> None:
        """Close the dialog and pass the answer on, or tell why the answer does not count yet."""
        if self._size_of_question != self._drawn_size:
            self._restart_reading()
        typed = self._desk.input
        is_early = (
            typed is None or typed.at - self._drawn_at < READING_TIME or typed.pause < MIN_PAUSE
        )
        if is_early or self._desk.is_stuck:
            self.notify("Read it first, then answer.", severity="warning", markup=False)
            return
        is_whole = self._is_end_visible(self._text) and self._is_end_visible(self._allow)
        if is_allowed and not is_whole:
            text = "Not all of it is seen: scroll by ↓, or make the terminal larger."
            self.notify(text, severity="warning", markup=False)
            return
        self.dismiss()  # First, since the answer ends the request, which `show_view` would report.
        station = self._desk.station
        answer = station.approvals.answer(self._request.number, allowed=is_allowed)
        self._desk.report_failure(answer)
        self._desk.update_screen()

    def action_scroll(self, step: int) -> None:
        """Scroll down (1) or up (-1) by three lines, by fewer if not so many are visible."""
        box = self.query_one(VerticalScroll)
        box.scroll_relative(y=step * min(3, max(box.size.height, 1)), animate=False)
