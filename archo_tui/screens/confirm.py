"""A question with a few answers; the safe one stands first and has the focus."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Button, Static

from archo_tui.screens.dialog import Dialog


class Confirm(Dialog[str]):
    """Ends with the words of the answer; escape gives the safe one."""

    BINDINGS = [("escape", "safe", "Safe answer")]

    def __init__(self, title: str, question: str, *answers: str) -> None:
        super().__init__()
        self.title, self._question, self._answers = title, question, answers

    @property
    def safe(self) -> str:
        """The answer that changes nothing."""
        return self._answers[0]

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self.title
            with VerticalScroll(classes="question", can_focus=False):
                yield Static(Content(self._question))
            with Horizontal(classes="answers"):
                for number, answer in enumerate(self._answers):
                    yield Button(answer, id=f"answer-{number}", compact=True)

    def on_mount(self) -> None:
        self.query_one("#answer-0").focus()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        self.end(str(event.button.label))

    def action_safe(self) -> None:
        """Change nothing."""
        self.end(self.safe)
