"""A question with a few answers; the safe one stands first and has the focus."""

from __future__ import annotations

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Dialog
from archo_tui.widgets.button import Button


class Confirm(Dialog[str]):
    """Ends with the words of the answer; escape gives the safe one."""

    closes_at_stop = True

    BINDINGS = [
        ("escape,n", "safe", "Safe answer"),
        ("y", "yes", "The answer that acts"),
        ("left", "app.focus_previous", "The answer before"),
        ("right", "app.focus_next", "The next answer"),
    ]

    def __init__(self, title: str, question: str, *answers: str) -> None:
        super().__init__()
        self.title, self._question, self._answers = title, question, answers

    @property
    def safe(self) -> str:
        """The answer that changes nothing."""
        return self._answers[0]

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self.title
            box.border_subtitle = "← → or first letter, enter   esc no"
            with VerticalScroll(classes="question", can_focus=False):
                yield Static(Content(self._question))
            with Horizontal(classes="answers"):
                for number, answer in enumerate(self._answers):
                    yield Button(answer, id=f"answer-{number}", compact=True)

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#answer-0"))

    def on_button_pressed(self, event: Button.Pressed) -> None:
        self.dismiss(str(event.button.label))

    def on_key(self, event: events.Key) -> None:
        """The first letter of an answer chooses it, when it is that answer's alone."""
        letter = (event.character or "").casefold()
        fitting = [n for n, answer in enumerate(self._answers) if answer.casefold()[0] == letter]
        if len(fitting) == 1 and letter not in ("y", "n"):
            event.stop()
            self.dismiss(self._answers[fitting[0]])

    def action_yes(self) -> None:
        """The answer that acts, when there is only one."""
        if len(self._answers) == 2:
            self.dismiss(self._answers[1])

    def action_safe(self) -> None:
        """Change nothing."""
        self.dismiss(self.safe)
