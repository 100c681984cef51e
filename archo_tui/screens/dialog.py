"""What all dialogs have: they end once, however often their keys are pressed."""

from __future__ import annotations

from typing import ClassVar

from textual.content import Content
from textual.screen import ModalScreen, ScreenResultType
from textual.widgets import Button, Static

from archo_tui.widgets.field import Field


class Dialog(ModalScreen[ScreenResultType]):
    """Base of the dialogs."""

    def end(self, result: ScreenResultType | None = None) -> None:
        """Close with a result. A second enter, or an answer that comes late, changes nothing."""
        if self.is_current:
            self.dismiss(result)

    def action_close(self) -> None:
        """Back to where the focus was, with nothing changed."""
        self.end()

    def say(self, text: str) -> None:
        """What is wrong, or going on; nothing when the dialog was left meanwhile."""
        for line in self.query(".error").results(Static):
            line.update(Content(text))


class Form(Dialog[None]):
    """A field and two buttons; stays open, with what is wrong in its `.error` line, until done."""

    BINDINGS = [("escape", "close", "Close")]

    submits: ClassVar[str]  # the id of the button that does what enter does
    standing = ""  # what the line says while nothing is wrong with what was typed

    def on_input_changed(self) -> None:
        self.say(self.standing)

    def on_input_submitted(self, event: Field.Submitted) -> None:
        self.submit(event.value)  # as it was: the keys behind enter may have changed it since

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == self.submits:
            self.submit(self.query_one(Field).value)
        else:
            self.action_close()

    def submit(self, typed: str) -> None:
        """Check what was typed, and do it."""
        raise NotImplementedError
