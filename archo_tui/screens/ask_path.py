"""The dialog that asks for the path of a file, for work with that file."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.paths import typed_path
from archo_tui.safe_text import harmless
from archo_tui.screens.dialog import Form
from archo_tui.station import form_history
from archo_tui.terminal.app import COMMANDS, start_worker

_KIND = "a file"  # The name of these paths in the form history.
_SHOWN = 5  # Recent paths below the field; the arrows reach all.


class AskPath(Form):
    """A dialog with a field for a path, which stays open until the work with the path succeeds."""

    submit_label = "OK"

    def __init__(
        self, title: str, text: str, default: str, work: Callable[[Path], Awaitable[str]]
    ) -> None:
        """Create the dialog; `work` returns why it failed, or "", which closes the dialog."""
        text = f"{text}; a relative path starts at {Path.cwd()}:"
        super().__init__("path", default, title=title, text=text)
        self._default, self._work = default, work
        self._recent: list[str] = []  # The newest first.
        self._index = -1  # Of the recent path in the field; -1 if it is the default.

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self.title
            box.border_subtitle = "enter OK   ↑ ↓ recent files   esc cancel"
            yield Static(Content(self.text_above))
            yield self.field
            yield Static(classes="recent")
            yield from self.below_field()

    def on_mount(self) -> None:
        start_worker(self, self._load_recent, "recall")

    async def _load_recent(self) -> None:
        entries = await in_daemon(form_history.load, _KIND)
        self._recent = [texts[0] for texts in reversed(entries) if texts]
        shown = "\n".join(f"↑ {harmless(path)}" for path in self._recent[:_SHOWN])
        self.set_text(".recent", Content.styled(shown, "$quiet"))
        for recent in self.query(".recent"):
            recent.display = shown != ""

    def step(self, step: int) -> None:
        """Fill in an older path (-1) or a newer one (1), at last the one of the beginning."""
        self._index = min(max(self._index - step, -1), len(self._recent) - 1)
        self.field.fill(self._default if self._index < 0 else self._recent[self._index])

    def submit(self, typed: str) -> None:
        """Begin the work with the typed path, or show why it is none; a second call is ignored."""
        try:
            path = typed_path(typed.strip())
        except ArchoError as error:
            self.show_message(str(error))
            return
        if not self.is_asking:
            self.is_asking = True
            start_worker(self.app, partial(self._run_work, path), COMMANDS)

    async def _run_work(self, path: Path) -> None:
        failure = await self._work(path)
        if failure:
            self.is_asking = False
            self.show_message(failure)
            return
        await in_daemon(form_history.add, _KIND, [str(path.absolute())])
        self.dismiss()
