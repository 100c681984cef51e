"""A dialog that shows a long text, such as a traceback or a whole event."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.content import Content
from textual.markup import escape
from textual.widgets import Static

from archo_tui.screens.dialog import Dialog


class ShowText(Dialog[None]):
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
