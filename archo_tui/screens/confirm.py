"""The dialog that asks a question with a few answers, before something is done."""

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
    """A question with answers, of which the first is the safe one: escape and `n` give it.

    The safe answer has the focus at first; `y` gives the other one of two, the first letter of an
    answer that answer. A STOP closes the dialog without an answer.
    """

    closes_at_stop = True

    BINDINGS = [
        ("escape,n", "answer(0)", "Safe answer"),
        ("y", "yes", "The answer that acts"),
        ("left", "app.focus_previous", "The answer before"),
        ("right", "app.focus_next", "The next answer"),
    ]

    def __init__(
        self, title: str, question: str, answers: Sequence[str], on_answer: Callable[[str], object]
    ) -> None:
        """Create the dialog; `on_answer` gets the words of the answer after it was dismissed."""
        super().__init__()
        self.title, self._question, self._answers = title, question, answers
        self._on_answer = on_answer
        # The first letter of an answer chooses it, unless another answer begins with it, too.
        letters = [answer[0].casefold() for answer in answers]
        unique = [letter for letter in letters if letters.count(letter) == 1 and letter not in "yn"]
        keys = (
            (f"{letter},{letter.upper()}", f"answer({letters.index(letter)})", "")
            for letter in unique
        )
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
        """Give the second answer if there are just two; else do nothing."""
        if len(self._answers) == 2:
            self.action_answer(1)

    def action_answer(self, number: int) -> None:
        """Close the dialog and pass an answer by its place to `on_answer`; a second is ignored."""
        if not self.is_dismissed:
            self.dismiss()
            self._on_answer(self._answers[number])
