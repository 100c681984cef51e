"""What all dialogs have."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.screen import ModalScreen, ScreenResultType
from textual.widgets import Static

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import Snapshot
from archo_tui.screens.leaving import Leaving
from archo_tui.screens.main import MainScreen
from archo_tui.station.reason import Reason, obstacles
from archo_tui.station.station import View
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


class Dialog(ModalScreen[ScreenResultType], Leaving[ScreenResultType]):
    """Base of the dialogs."""

    _reason: Reason | None = None  # of a refusal that is shown
    _snapshot: Snapshot | None = None  # of the last view; None: there was none since it opened

    def compose(self) -> ComposeResult:
        yield from self.body()
        yield Below()

    def body(self) -> ComposeResult:
        """What the dialog holds."""
        raise NotImplementedError

    def action_close(self) -> None:
        """Back to where the focus was, with nothing changed."""
        self.dismiss()

    def say(self, text: str = "") -> None:
        """What is wrong, or going on."""
        self._reason = None
        self.write(".error", Content(text))

    def refuse(self, text: str) -> None:
        """Show why the robot or a node refuses, until what that may be about is over."""
        self.say(text)
        self._reason = Reason(obstacles)
        if self._snapshot is not None:
            self._reason.is_over(self._snapshot)  # notes what holds now

    def follow(self, view: View) -> None:
        """Take a refusal away when what it may be about is over."""
        self._snapshot = view.snapshot
        if self._reason is not None and self._reason.is_over(view.snapshot):
            self.say()

    def end(self, outcome: Outcome) -> None:
        """Done, or what is in the way; said beside it when the dialog was left meanwhile."""
        if outcome.ok:
            self.dismiss()
        elif self.has_left:
            self.notify(outcome.text, severity="error", markup=False)
        else:
            self.refuse(outcome.text)

    def write(self, selector: str, text: Content) -> None:
        """Fill a part of the dialog; nothing when it was left meanwhile, and has lost its parts."""
        for part in self.query(selector).results(Static):
            part.update(text)


class Form(Dialog[None]):
    """A field and two buttons; stays open, with what is wrong in its `.error` line, until done."""

    BINDINGS = [("escape", "close", "Close")]

    does: ClassVar[str]  # the word of the button that does what enter does
    standing = ""  # what the line says while nothing is wrong with what was typed

    def __init__(self, id: str, value: str = "", *, disabled: bool = False) -> None:
        """`id` is the field's, `value` stands in it; when it is `disabled`, it can only be read."""
        super().__init__()
        self.field = Field(
            value,
            id=id,
            changed=lambda: self.say(self.standing),
            submitted=self._submit,
            stepped=self.step,
        )
        self.field.disabled = disabled

    def below_field(self) -> ComposeResult:
        """Yield the line that says what is wrong, and the buttons."""
        yield Static(Content(self.standing), classes="error")
        with Horizontal(classes="answers"):
            yield Button("Cancel", self.action_close, id="leave")
            yield Button(self.does, self._submit, id="submit", disabled=self.field.disabled)

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#leave") if self.field.disabled else self.field)

    def step(self, step: int) -> None:
        """Do what the arrows up (-1) and down (1) do."""

    def _submit(self) -> None:
        self.submit(self.field.value)

    def submit(self, typed: str) -> None:
        """Check what was typed, and do it."""
        raise NotImplementedError
