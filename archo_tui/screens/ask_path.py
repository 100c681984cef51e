"""Asks for a file and does something with it; stays open, with the reason, until that is done."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widgets import Button, Input, Static

from archo_tui.screens.dialog import Dialog


class AskPath(Dialog[None]):
    """`work(path)` returns what is in the way, or an empty string when it is done."""

    BINDINGS = [("escape", "close", "Close")]

    def __init__(
        self, title: str, text: str, default: str, work: Callable[[Path], Awaitable[str]]
    ) -> None:
        super().__init__()
        self._title, self._text, self._default, self._work = title, text, default, work
        self._working = False

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self._title
            box.border_subtitle = "enter go on   esc leave"
            yield Static(Content(f"{self._text}, in {Path.cwd()} or with its whole path:"))
            field = Input(self._default, id="path", compact=True)
            field.cursor_blink = False
            yield field
            yield Static("", classes="error")
            with Horizontal(classes="answers"):
                yield Button("Leave", id="leave", compact=True)
                yield Button("Go on", id="go-on", compact=True)

    def on_mount(self) -> None:
        self.query_one("#path").focus()

    def on_input_changed(self) -> None:
        self._say("")

    def on_input_submitted(self) -> None:
        self._submit()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "go-on":
            self._submit()
        else:
            self.action_close()

    def action_close(self) -> None:
        """Leave things as they are."""
        self.end()

    def _submit(self) -> None:
        typed = self.query_one("#path", Input).value.strip()
        if not typed or "\0" in typed:
            self._say("type the name of a file")
        elif not self._working:
            self._working = True
            self.run_worker(self._try(Path(typed).expanduser()))

    async def _try(self, path: Path) -> None:
        said = await self._work(path)
        self._working = False
        if said:
            self._say(said)
        else:
            self.end()

    def _say(self, text: str) -> None:
        self.query_one(".error", Static).update(Content(text))
