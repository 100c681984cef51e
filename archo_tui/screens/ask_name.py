"""The dialog that asks for a name."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Form
from archo_tui.terminal.app import COMMANDS, start_worker


class AskName(Form):
    """A dialog with a field for a name, which stays open until the work with it succeeds."""

    submit_label = "Save"

    def __init__(self, title: str, text: str, work: Callable[[str], Awaitable[str]]) -> None:
        """Create the dialog; `work` returns why it failed, or "", which closes the dialog."""
        super().__init__("name")
        self._title, self._text, self._work = title, text, work

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self._title
            box.border_subtitle = "enter save   esc cancel"
            yield Static(Content(self._text))
            yield self.field
            yield from self.below_field()

    def submit(self, typed: str) -> None:
        """Begin the work with the typed name; a second call is ignored."""
        if not self.is_asking:
            self.is_asking = True
            start_worker(self.app, partial(self._run_work, typed.strip()), COMMANDS)

    async def _run_work(self, name: str) -> None:
        failure = await self._work(name)
        self.is_asking = False
        if failure:
            self.show_message(failure)
        else:
            self.dismiss()
