"""Asks for a file and does something with it; stays open, with the reason, until that is done."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widgets import Button, Static

from archo_tui.screens.dialog import Form
from archo_tui.widgets.field import Field


class AskPath(Form):
    """`work(path)` returns what is in the way, or an empty string when it is done."""

    submits = "go-on"

    def __init__(
        self, title: str, text: str, default: str, work: Callable[[Path], Awaitable[str]]
    ) -> None:
        super().__init__()
        self._title, self._text, self._default, self._work = title, text, default, work
        self._working = False

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self._title
            box.border_subtitle = "enter OK   esc cancel"
            yield Static(Content(f"{self._text}; a relative path starts at {Path.cwd()}:"))
            yield Field(self._default, id="path")
            yield Static("", classes="error")
            with Horizontal(classes="answers"):
                yield Button("Cancel", id="leave", compact=True)
                yield Button("OK", id="go-on", compact=True)

    def on_mount(self) -> None:
        self.query_one("#path").focus()

    def submit(self, typed: str) -> None:
        typed = typed.strip()
        if not typed or "\0" in typed:
            self.say("type the name of a file")
            return
        try:
            path = Path(typed).expanduser()
        except RuntimeError:
            self.say(f"no home folder is known for {typed.partition('/')[0]}")
            return
        if not self._working:
            self._working = True
            self.run_worker(self._try(path))

    async def _try(self, path: Path) -> None:
        said = await self._work(path)
        self._working = False
        if said:
            self.say(said)
        else:
            self.end()
