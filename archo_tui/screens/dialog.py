"""The bases of all dialogs, and of those with one field."""

from __future__ import annotations

from typing import Any, ClassVar

from textual.app import App, ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.markup import escape
from textual.screen import ModalScreen, ScreenResultType
from textual.widgets import Static

from archo_tui.robot.outcome import Outcome
from archo_tui.screens.dismissable import Dismissable
from archo_tui.screens.main import MainScreen
from archo_tui.widgets.button import Button
from archo_tui.widgets.field import Field
from archo_tui.widgets.line import Line
from archo_tui.widgets.notices import NoticeLine

HEAD_FROM = 20  # Rows of the terminal from which the lines at the top are shown.
DEFAULT_BUTTONS = ("submit", "send")  # The ids of buttons that enter presses in a field.


def main_screen(app: App[Any]) -> MainScreen | None:
    """Return the main screen beneath the dialogs; None before there is one."""
    return next((screen for screen in app.screen_stack if isinstance(screen, MainScreen)), None)


class DialogHead(Vertical):
    """The lines at the top of a dialog: copies of the main screen's, not dimmed, and the notices.

    Notices take the place of a banner that is not needed, or move the dialog: they cover nothing.
    """

    def __init__(self) -> None:
        super().__init__(classes="above")
        self._notice_line = NoticeLine()
        self._main: MainScreen | None = None

    def compose(self) -> ComposeResult:
        self._main = main_screen(self.app)
        for _ in self._main.head if self._main is not None else ():
            yield Line()
        yield self._notice_line

    def on_mount(self) -> None:
        if self._main is not None:
            self._main.on_head.append(self._show)
            self._show()

    def on_unmount(self) -> None:
        if self._main is not None:
            self._main.on_head.remove(self._show)

    @property
    def rows(self) -> int:
        """The number of rows that the lines take; 0 in a terminal that is too low for them."""
        has_room = self.app.size.height >= HEAD_FROM
        return len(self._main.head) if self._main is not None and has_room else 0

    def _show(self) -> None:
        main = self._main
        if main is None:
            return
        shown = self.rows - (bool(main.notices) and not main.is_banner_needed)
        for number, (line, text) in enumerate(zip(self.query(Line), main.head, strict=False)):
            line.display = number < shown
            line.show(text)
        self._notice_line.show(main.notices, main.size.width)
        self.display = bool(self.rows or main.notices)


class DialogFooter(Line):
    """The line at the bottom of a dialog: the keys that worked in dialogs when it was opened."""

    def __init__(self) -> None:
        super().__init__(classes="below")

    def on_mount(self) -> None:
        main = main_screen(self.app)
        if main is not None:
            self.show(main.everywhere_keys)


class Dialog(ModalScreen[ScreenResultType], Dismissable[ScreenResultType]):
    """A dialog over the main screen, whose header and banner stay lit above, and STOP's key below.

    A subclass composes its widgets in `body`; messages are shown in its `.error` widget.
    """

    head: DialogHead
    _shows_refusal = False

    def compose(self) -> ComposeResult:
        self.head = DialogHead()
        yield self.head
        yield from self.body()
        yield DialogFooter()

    def on_descendant_focus(self) -> None:
        """Highlight the button that enter presses, while a field has the focus."""
        in_field = isinstance(self.focused, Field)
        for button in self.query(Button):
            button.set_class(in_field and button.id in DEFAULT_BUTTONS, "-default")

    def body(self) -> ComposeResult:
        """Yield the widgets of the dialog; a subclass must define it."""
        raise NotImplementedError

    def action_close(self) -> None:
        """Close the dialog without a result."""
        self.dismiss()

    def show_message(self, text: str = "") -> None:
        """Show a message in the dialog, in place of the one before; "" removes that."""
        self._shows_refusal = False
        self.set_text(".error", Content(text))

    def refuse(self, text: str) -> None:
        """Show why the robot or a node refused, until the next key."""
        self.show_message(text)
        self._shows_refusal = True

    def forget_refusal(self) -> None:
        """Remove a refusal that is shown: a key was pressed."""
        if self._shows_refusal:
            self.show_message()

    def finish(self, outcome: Outcome) -> None:
        """Close the dialog if its work succeeded; otherwise show why not, and stay open.

        If the dialog was dismissed in the meantime, a notification shows a failure.
        """
        if outcome.ok:
            self.dismiss()
        elif self.is_dismissed:
            self.notify(outcome.text, severity="error", markup=False)
        else:
            self.refuse(outcome.text)

    def set_text(self, selector: str, text: Content) -> None:
        """Set the text of all Static widgets that a CSS selector matches, if there are any."""
        for widget in self.query(selector).results(Static):
            widget.update(text)


class Form(Dialog[None]):
    """A dialog with a field and two buttons; a subclass keeps it open until its work succeeded."""

    BINDINGS = [("escape", "close", "Close")]

    submit_label: ClassVar[str]  # On the button that does the same as enter.
    hint = Content("")  # Below the field while there is no message.

    def __init__(
        self, id: str, value: str = "", *, title: str = "", text: str = "", disabled: bool = False
    ) -> None:
        super().__init__()
        self.title, self.text_above = title, text
        self.field = Field(
            value,
            id=id,
            changed=self.show_message,
            submitted=self._submit,
            stepped=self.step,
        )
        self.field.disabled = disabled

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = escape(str(self.title))
            box.border_subtitle = f"enter {self.submit_label.lower()}   esc cancel"
            yield Static(Content(self.text_above))
            yield self.field
            yield from self.below_field()

    def below_field(self) -> ComposeResult:
        """Yield the line for messages, and the buttons, for `body`."""
        yield Static(self.hint, classes="error")
        with Horizontal(classes="answers"):
            yield Button("Cancel", self.action_close, id="leave")
            yield Button(self.submit_label, self._submit, id="submit", disabled=self.field.disabled)

    def show_message(self, text: str = "") -> None:
        """Show a message in place of the hint until something is typed; "" shows the hint again."""
        super().show_message(text)
        if not text:
            self.set_text(".error", self.hint)

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#leave") if self.field.disabled else self.field)

    def step(self, step: int) -> None:
        """Do nothing; a subclass may handle the arrow up (-1) or down (1) here."""

    def _submit(self) -> None:
        self.submit(self.field.value)

    def submit(self, typed: str) -> None:
        """Check the typed text, and begin the work; a subclass must define it."""
        raise NotImplementedError
