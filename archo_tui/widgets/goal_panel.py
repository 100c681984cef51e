"""Panel 3: send the robot to a shelf, see it drive, cancel."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.message import Message
from textual.widgets import Button, Label

from archo_tui import goal_text, state_text
from archo_tui.robot.state import MOVE, Phase, Snapshot
from archo_tui.station import View
from archo_tui.widgets.field import INTEGER, Field
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.styled import content


class GoalPanel(Panel):
    """A form, a bar, where the goal stands, and the goals before."""

    number, title_text = 3, "Go to shelf"
    keys = (("cancel", "cancel"),)
    _about: object = None  # what the robot's answer that is shown was about

    class Send(Message):
        """The operator wants the robot to go there."""

        def __init__(self, shelf: int) -> None:
            super().__init__()
            self.shelf = shelf

    def __init__(self) -> None:
        super().__init__()
        self.field = Field(id="shelf", takes=INTEGER)
        self._go = Button("Go", id="go", compact=True)
        self._cancel = Button("Cancel", id="cancel", compact=True, action="app.command('cancel')")
        self._hint, self._bar = Line(id="goal-hint"), Line(id="goal-bar")
        self._line, self._history = Line(id="goal-line"), Line(id="goal-history")

    def compose(self) -> ComposeResult:
        with Horizontal(classes="buttons"):
            yield Label("Shelf ")
            yield from (self.field, self._go, self._cancel, self._hint)
        yield from (self._bar, self._line, self._history)

    def show(self, view: View) -> None:
        self.show_keys(view, "enter go")
        snapshot = view.snapshot
        width = self._bar.size.width
        self._bar.show(content(goal_text.goal_bar(snapshot.goal, width)))
        line = goal_text.goal_line(snapshot, view.now, view.key("go"))
        self._line.show(content(line))
        before = goal_text.goal_history(snapshot.history, width)
        self._history.show(content(before))
        for button in (self._go, self._cancel):
            self.grey(view, {MOVE: button})
        if self._about not in (None, _situation(snapshot)):
            self.hint("")

    def take_focus(self) -> None:
        self.screen.set_focus(self.field)

    def on_input_changed(self) -> None:
        self.hint("")

    def on_input_submitted(self, event: Field.Submitted) -> None:
        self.submit(event.value)  # as it was: the keys behind enter may have changed it since

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "go":
            self.submit(self.field.value)

    def on_field_refused(self, event: Field.Refused) -> None:
        self.hint(event.reason)

    def hint(self, text: str) -> None:
        """Say why what was typed cannot be sent."""
        self._about = None
        self._hint.show(content(((text, state_text.BAD),)))

    def answer(self, text: str, snapshot: Snapshot) -> None:
        """Say why the robot does not go there, while that is so."""
        self.hint(text)
        self._about = _situation(snapshot)

    def submit(self, typed: str) -> None:
        """Ask for the shelf that was typed, or say what is wrong with it."""
        try:
            shelf = goal_text.parse_shelf(typed)
        except ValueError as error:
            self.hint(str(error))
            return
        self.hint("")
        self.post_message(self.Send(shelf))


def _situation(snapshot: Snapshot) -> object:
    """What a refusal may be about: another goal, one without news, nobody there to ask."""
    goal = snapshot.goal
    if goal is None:
        return MOVE in snapshot.offered
    doubtful = goal.phase in (Phase.UNKNOWN, Phase.LOST)
    return MOVE in snapshot.offered, goal.sent, goal.is_running, doubtful
