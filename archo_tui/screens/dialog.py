"""What all dialogs have: they end once, however often their keys are pressed."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.await_complete import AwaitComplete
from textual.content import Content
from textual.screen import ModalScreen, ScreenResultType
from textual.widgets import Static

from archo_tui.robot.outcome import Outcome
from archo_tui.screens.base import Base
from archo_tui.screens.main import MainScreen
from archo_tui.widgets.button import Button
from archo_tui.widgets.field import Field
from archo_tui.widgets.line import Line


class Below(Line):
    """The keys that work in dialogs too, STOP's first of all, where the footer is."""

    def __init__(self) -> None:
        super().__init__(classes="below")

    def on_mount(self) -> None:
        main = self.app.screen_stack[0]
        if isinstance(main, MainScreen):
            self.show(main.everywhere)


class Leaving(Base[ScreenResultType]):
    """A screen that is dismissed once; under another one, when that has gone.

    Textual would dismiss the one on top, even while that is still being built. It is the last base:
    Textual looks for styles and component classes along the first.
    """

    closes_at_stop: ClassVar[bool] = False  # its question was about the robot before the STOP
    _left: tuple[ScreenResultType | None] | None = None  # with what, once that is known

    @property
    def has_left(self) -> bool:
        """True when it was dismissed, whether it has gone yet or not."""
        return self._left is not None

    def dismiss(self, result: ScreenResultType | None = None) -> AwaitComplete:
        """A second enter, or an answer that comes late, changes nothing."""
        if self._left is None:
            self._left = (result,)
        if not self.is_mounted:  # its parts are looked for while it is built
            self.call_later(self.dismiss)
            return AwaitComplete()
        return super().dismiss(*self._left) if self.is_active else AwaitComplete()

    def on_screen_resume(self) -> None:
        if self._left is not None:
            self.dismiss()


class Dialog(ModalScreen[ScreenResultType], Leaving[ScreenResultType]):
    """Base of the dialogs."""

    def compose(self) -> ComposeResult:
        yield from self.body()
        yield Below()

    def body(self) -> ComposeResult:
        """What the dialog holds."""
        raise NotImplementedError

    def action_close(self) -> None:
        """Back to where the focus was, with nothing changed."""
        self.dismiss()

    def say(self, text: str) -> None:
        """What is wrong, or going on."""
        self.write(".error", Content(text))

    def end(self, outcome: Outcome) -> None:
        """Done, or what is in the way; said beside it when the dialog was left meanwhile."""
        if outcome.ok:
            self.dismiss()
        elif self.has_left:
            self.notify(outcome.text, severity="error", markup=False)
        else:
            self.say(outcome.text)

    def write(self, selector: str, text: Content) -> None:
        """Fill a part of the dialog; nothing when it was left meanwhile, and has lost its parts."""
        for part in self.query(selector).results(Static):
            part.update(text)


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
