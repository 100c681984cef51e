"""A question with a few answers; the safe one stands first and has the focus."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from textual.app import ComposeResult
from textual.binding import BindingsMap
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Dialog
from archo_tui.widgets.button import Button


class Confirm(Dialog[None]):
    """Tells the words of the answer; escape gives the safe one, a STOP none."""

    closes_at_stop = True

    BINDINGS = [
        ("escape,n", "answer(0)", "Safe answer"),
        ("y", "yes", "The answer that acts"),
        ("left", "app.focus_previous", "The answer before"),
        ("right", "app.focus_next", "The next answer"),
    ]

    def __init__(
        self, title: str, question: str, answers: Sequence[str], answered: Callable[[str], object]
    ) -> None:
        """Create a question; the first of the `answers` changes nothing."""
        super().__init__()
        self.title, self._question, self._answers = title, question, answers
        self._answered = answered
        # the first letter of an answer chooses it, when it is that answer's alone
        letters = [answer[0].casefold() for answer in answers]
        own = [letter for letter in letters if letters.count(letter) == 1 and letter not in "yn"]
        keys = ((f"{one},{one.upper()}", f"answer({letters.index(one)})", "") for one in own)
        self._bindings = BindingsMap.merge((self._bindings, BindingsMap(keys)))

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self.title
            box.border_subtitle = "← → or first letter, enter   esc no"
            with VerticalScroll(classes="question", can_focus=False):
                yield Static(Content(self._question))
            with Horizontal(classes="answers"):
                for number, answer in enumerate(self._answers):
                    choose = partial(self.action_answer, number)
                    yield Button(answer, choose, id=f"answer-{number}")

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#answer-0"))

    def action_yes(self) -> None:
        """Give the answer that acts, when there is only one."""
        if len(self._answers) == 2:
            self.action_answer(1)

    def action_answer(self, number: int) -> None:
        """Give an answer by its place."""
        if not self.has_left:
            self.dismiss()
            self._answered(self._answers[number])
