"""The base of all dialogs, and those for a text, a list, a question, a line and a path."""

from __future__ import annotations

import os.path
from collections.abc import Awaitable, Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

from textual import events
from textual.app import App, ComposeResult
from textual.await_complete import AwaitComplete
from textual.binding import Binding, BindingsMap
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.markup import escape
from textual.screen import ModalScreen
from textual.widgets import Static

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError
from archo_tui.base.paths import typed_path
from archo_tui.robot.outcome import Outcome
from archo_tui.screen.base import Base
from archo_tui.screen.main import MainScreen
from archo_tui.screen.terminal.app import COMMANDS, start_worker
from archo_tui.screen.widgets.bars import NoticeLine
from archo_tui.screen.widgets.field import Button, Field
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.panel import ScreenState
from archo_tui.screen.widgets.rows import Rows
from archo_tui.text.columns import Columns, Text
from archo_tui.text.state import not_drawn

T = TypeVar("T")
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


class Dialog(ModalScreen[None], Base):
    """A dialog over the main screen, whose header and banner stay lit above, and STOP's key below.

    A subclass composes its widgets in `body`; messages are shown in its `.error` widget. It is
    dismissed once, however often its keys are pressed; while a further dialog lies over it, it goes
    when that has gone.
    """

    head: DialogHead
    # A STOP closes it, since it asks about the robot before the STOP.
    closes_at_stop: ClassVar[bool] = False
    # A worker waits for an answer that may close it; keys pressed meanwhile wait, too.
    is_asking = False
    is_dismissed = False  # True once `dismiss` was called, though it may still be shown.
    _shows_refusal = False
    _not_drawn = ""  # Why the last state could not be drawn.

    def dismiss(self, result: None = None) -> AwaitComplete:
        """Close the dialog, at once or as soon as it is in front.

        What is returned may be awaited only where it closes at once.
        """
        self.is_dismissed = True
        if not self.is_mounted:  # Textual still looks for the widgets of the screen.
            self.call_later(self.dismiss)
            return AwaitComplete()
        return super().dismiss(None) if self.is_active else AwaitComplete()

    def ask(
        self,
        work: Callable[[], Awaitable[T]],
        show: Callable[[T], object],
        waiting: str = "",  # Shown until the answer has come.
        group: str = COMMANDS,
    ) -> None:
        """Await an answer and show it; until then keys wait, and nothing else is asked."""
        if self.is_asking:
            return
        self.is_asking = True
        if waiting:
            self.show_message(waiting)

        async def answer() -> None:
            try:
                result = await work()
            finally:
                self.is_asking = False
            show(result)

        start_worker(self.app, answer, group)

    def stop_waiting(self) -> None:
        """Close the dialog for ctrl+c, though the answer that it waits for has not come."""
        self.dismiss()

    def on_screen_resume(self, event: events.ScreenResume) -> None:
        if self.is_dismissed:
            self.dismiss()

    def update_view(self, view: ScreenState) -> None:
        """Show a new state; if it cannot be drawn, say so once, and leave the other screens be."""
        try:
            self.show_view(view)
            self._not_drawn = ""
        except Exception as error:
            text = not_drawn(error)
            if text != self._not_drawn:
                self._not_drawn = text
                self.notify(f"{type(self).__name__} {text}", severity="error", markup=False)

    def show_view(self, view: ScreenState) -> None:
        """Do nothing; a subclass shows here each new state while the dialog is mounted."""

    def compose(self) -> ComposeResult:
        self.head = DialogHead()
        yield self.head
        yield from self.body()
        main, footer = main_screen(self.app), Line(classes="below")
        if main is not None:
            footer.show(main.everywhere_keys)
        yield footer

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


class Form(Dialog):
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
        )
        self.field.disabled = disabled

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = escape(str(self.title))
            box.border_subtitle = f"enter {self.submit_label.lower()}   esc cancel"
            yield from self.above_field()
            yield self.field
            yield from self.below_field()

    def above_field(self) -> ComposeResult:
        """Yield what stands above the field, for `body`: by default `text_above`."""
        yield Static(Content(self.text_above))

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

    def _submit(self) -> None:
        self.submit(self.field.value)

    def submit(self, typed: str) -> None:
        """Check the typed text, and begin the work; a subclass must define it."""
        raise NotImplementedError


class ShowText(Dialog):
    """A dialog with a text that scrolls; escape, enter and q close it."""

    BINDINGS = [("escape,enter,q", "close", "Close")]

    def __init__(self, title: str, text: str) -> None:
        super().__init__()
        self._title, self._text = title, text

    def body(self) -> ComposeResult:
        with VerticalScroll(classes="dialog reading") as box:
            box.border_title = escape(self._title)
            box.border_subtitle = "esc close"
            yield Static(Content(self._text))


class ListDialog(Dialog, Generic[T]):
    """The base of dialogs with a list, which are as high as its rows."""

    BINDINGS = [Binding("escape,q", "close", "Close")]

    keys_text: ClassVar[str] = "esc close"  # On the lower border.

    def __init__(
        self,
        title: str,
        lines: Callable[[T, int, Columns], Sequence[Text]],
        key: Callable[[T], object],
        *,
        action: str = "",
    ) -> None:
        """Create the dialog; what the arguments are, `Rows` says."""
        super().__init__()
        self.rows = Rows(lines, key, id=title.lower(), empty="", action=action, wraps=True)
        self.title, self.box = title, Vertical(self.rows, classes="dialog reading")

    def body(self) -> ComposeResult:
        self.box.border_title, self.box.border_subtitle = self.title, self.keys_text
        yield self.box

    def on_mount(self) -> None:
        self.set_focus(self.rows)

    def show_items(self, items: Sequence[T], empty: str | None = None) -> None:
        """Show other items in place of those before, or a text in the place of none."""
        self.rows.show(items, empty)
        self.box.styles.height = max(self.rows.virtual_size.height, 1) + 2  # Two for the border.


class Confirm(Dialog):
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
        self,
        title: str,
        question: str,
        answers: Sequence[str],
        on_answer: Callable[[str], object],
        close_if_over: Callable[[], bool],
    ) -> None:
        """Create the dialog; `on_answer` gets the words of the answer after it was dismissed.

        It closes without an answer once `close_if_over`, which tells the person why, is true.
        """
        super().__init__()
        self._close_if_over = close_if_over
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

    def show_view(self, view: ScreenState) -> None:
        if not self.is_dismissed and self._close_if_over():
            self.dismiss()

    def action_yes(self) -> None:
        """Give the second answer if there are just two; else do nothing."""
        if len(self._answers) == 2:
            self.action_answer(1)

    def action_answer(self, number: int) -> None:
        """Close the dialog and pass an answer by its place to `on_answer`; a second is ignored.

        What acts is no answer any more once `close_if_over` is true.
        """
        if not self.is_dismissed:
            is_over = number > 0 and self._close_if_over()
            self.dismiss()
            if not is_over:
                self._on_answer(self._answers[number])


class AskText(Form):
    """A dialog with a field, which stays open until the work with the typed text succeeds."""

    submit_label = "OK"

    def __init__(
        self, id: str, title: str, text: str, default: str, work: Callable[[str], Awaitable[str]]
    ) -> None:
        """Create the dialog; `work` returns why it failed, or "", which closes the dialog."""
        super().__init__(id, default, title=title, text=text)
        self._work = work

    def submit(self, typed: str) -> None:
        self.ask(partial(self._work, typed.strip()), self._show_failure)

    def _show_failure(self, failure: str) -> None:
        if failure:
            self.show_message(failure)
        else:
            self.dismiss()


class AskPath(AskText):
    """A dialog with a field for a path."""

    def __init__(
        self,
        title: str,
        text: str,
        default: str,
        work: Callable[[Path], Awaitable[str]],
        *,
        writes: bool = False,  # A file that exists is replaced if its path is entered twice.
    ) -> None:
        """Create the dialog; `work` returns why it failed, or "", which closes the dialog."""
        text = f"{text}; a relative path starts at {Path.cwd()}:"
        super().__init__("path", title, text, default, self._work_with_path)
        self._of_path, self._writes, self._warned = work, writes, set[Path]()

    async def _work_with_path(self, typed: str) -> str:
        try:
            path = typed_path(typed)
        except ArchoError as error:
            return str(error)
        if self._writes and path not in self._warned and await in_daemon(os.path.exists, path):
            self._warned.add(path)
            return f"{path} already exists: press enter again to overwrite"
        return await self._of_path(path)
