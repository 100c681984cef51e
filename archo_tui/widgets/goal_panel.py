"""Panel 3: send the robot to a shelf, see it drive, cancel."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.message import Message
from textual.widgets import Button, Input, Label

from archo_tui.robot.state import MOVE
from archo_tui.widgets import goal_words, words
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.view import View

_INT32_MAX = 2**31 - 1  # the goal's field is an int32
_SHOWN = 20  # characters of a wrong text that are shown


def parse_shelf(text: str) -> int:
    """The shelf number that a person typed. Raises ValueError with one line that says why not.

    Which shelves exist is the robot's to say.
    """
    text = text.strip()
    if not text:
        raise ValueError("type a shelf number")
    shown = text if len(text) <= _SHOWN else f"{text[:_SHOWN]} ..."
    if not text.removeprefix("-").isdecimal() or not text.isascii():
        raise ValueError(f"not a shelf number: {shown}")
    if len(text) > _SHOWN or int(text) > _INT32_MAX:
        raise ValueError(f"no such shelf: {shown}")
    if int(text) < 1:
        raise ValueError(f"shelves are numbered from 1: {shown}")
    return int(text)


class GoalPanel(Panel):
    """A form, a bar, where the goal stands, and the goals before."""

    number, title_text = 3, "Go to shelf"
    keys = (("cancel", "cancel"),)

    class Send(Message):
        """The operator wants the robot to go there."""

        def __init__(self, shelf: int) -> None:
            super().__init__()
            self.shelf = shelf

    def compose(self) -> ComposeResult:
        with Horizontal(classes="buttons"):
            yield Label("Shelf ")
            field = Input(id="shelf", compact=True)
            field.cursor_blink = False  # a blinking cursor is traffic over SSH
            yield field
            yield Button("Go", id="go", compact=True)
            yield Button("Cancel", id="cancel", compact=True, action="app.command('cancel')")
            yield Line(id="goal-hint")
        yield Line(id="goal-bar")
        yield Line(id="goal-line")
        yield Line(id="goal-history")

    def show(self, view: View) -> None:
        self.show_keys(view, "enter go")
        snapshot = view.snapshot
        bar = self.query_one("#goal-bar", Line)
        bar.show(goal_words.goal_bar(snapshot.goal, bar.size.width))
        self.query_one("#goal-line", Line).show(
            goal_words.goal_line(snapshot, view.now, view.key("go"))
        )
        before = goal_words.goal_history(snapshot.history, bar.size.width)
        self.query_one("#goal-history", Line).show(before)
        self.grey(view, go=MOVE, cancel=MOVE)

    def take_focus(self) -> None:
        self.screen.set_focus(self.query_one("#shelf"))

    def on_input_changed(self) -> None:
        self.hint("")

    def on_input_submitted(self) -> None:
        self.submit()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "go":
            self.submit()

    def hint(self, text: str) -> None:
        """Say why what was typed cannot be sent."""
        self.query_one("#goal-hint", Line).show(Content.styled(text, words.BAD))

    def submit(self) -> None:
        """Ask for the shelf that was typed, or say what is wrong with it."""
        try:
            shelf = parse_shelf(self.query_one("#shelf", Input).value)
        except ValueError as error:
            self.hint(str(error))
            return
        self.hint("")
        self.post_message(self.Send(shelf))
