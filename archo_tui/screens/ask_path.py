"""Asks for a file and does something with it; stays open, with the reason, until that is done."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from archo_tui.daemon_threads import in_daemon
from archo_tui.robot.text import harmless
from archo_tui.screens.dialog import Form
from archo_tui.station import form_history
from archo_tui.terminal.app import COMMANDS, start_worker

_KIND = "a file"  # under which they are kept
_SHOWN = 5  # recent files


class AskPath(Form):
    """`work(path)` returns what is in the way, or an empty string when it is done.

    The arrows lead through the files that were used before.
    """

    does = "OK"

    def __init__(
        self, title: str, text: str, default: str, work: Callable[[Path], Awaitable[str]]
    ) -> None:
        super().__init__("path", default)
        self._title, self._text, self._default, self._work = title, text, default, work
        self._recent: list[str] = []  # the newest first
        self._place = -1  # of them in the field; -1: none

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self._title
            box.border_subtitle = "enter OK   ↑ ↓ recent files   esc cancel"
            yield Static(Content(f"{self._text}; a relative path starts at {Path.cwd()}:"))
            yield self.field
            yield Static(classes="recent")
            yield from self.below_field()

    def on_mount(self) -> None:
        start_worker(self, self._recall, "recall")

    async def _recall(self) -> None:
        used = await in_daemon(form_history.load, _KIND)
        self._recent = [texts[0] for texts in reversed(used) if texts]
        shown = "\n".join(f"↑ {harmless(path)}" for path in self._recent[:_SHOWN])
        self.write(".recent", Content.styled(shown, "$quiet"))

    def step(self, step: int) -> None:
        """Up to the file before, down to the one after it, at last what stood there at first."""
        self._place = min(max(self._place - step, -1), len(self._recent) - 1)
        self.field.fill(self._default if self._place < 0 else self._recent[self._place])

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
        if not self.is_asking:
            self.is_asking = True
            start_worker(self.app, partial(self._try, path), COMMANDS)

    async def _try(self, path: Path) -> None:
        said = await self._work(path)
        if said:
            self.is_asking = False
            self.say(said)
            return
        await in_daemon(form_history.add, _KIND, [str(path.absolute())])
        self.dismiss()
