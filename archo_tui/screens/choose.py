"""A list to choose from: type to narrow it, enter takes the row."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from archo_tui.robot.text import harmless
from archo_tui.screens.dialog import Dialog
from archo_tui.terminal.app import COMMANDS
from archo_tui.widgets.field import Field

_SHOWN = 12  # rows


class Choose(Dialog[None]):
    """`then(name)` is done with what was chosen; escape chooses nothing."""

    closes_at_stop = True

    BINDINGS = [("escape", "close", "Close")]

    def __init__(
        self,
        title: str,
        rows: Sequence[tuple[str, str]],
        then: Callable[[str], Coroutine[Any, Any, None]],
    ) -> None:
        """`rows` are names, with what is said beside each."""
        super().__init__()
        self.title, self._all, self._then = title, list(rows), then
        self._cursor = 0

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self.title
            box.border_subtitle = "type to narrow   ↑ ↓, enter   esc cancel"
            yield Field(id="narrow", placeholder="part of the name")
            yield Static(classes="rows")

    def on_mount(self) -> None:
        self.set_focus(self.query_one(Field))
        self._draw()

    @property
    def _rows(self) -> list[tuple[str, str]]:
        part = self.query_one(Field).value.strip().casefold()
        return [row for row in self._all if part in row[0].casefold()]

    def on_input_changed(self) -> None:
        self._cursor = 0
        self._draw()

    def on_input_submitted(self, event: Field.Submitted) -> None:
        rows = self._rows
        if rows and self.is_current:
            self.dismiss()
            self.app.run_worker(self._then(rows[self._cursor][0]), group=COMMANDS)

    def on_field_recall(self, event: Field.Recall) -> None:
        """The arrows move the cursor."""
        self._cursor = min(max(self._cursor + event.step, 0), max(len(self._rows) - 1, 0))
        self._draw()

    def _draw(self) -> None:
        rows = self._rows
        first = max(min(self._cursor - _SHOWN + 1, len(rows) - _SHOWN), 0)
        lines = []
        for number, (name, beside) in enumerate(rows[first : first + _SHOWN], first):
            text = f"{harmless(name)}  "
            style = "reverse" if number == self._cursor else ""
            lines.append(Content.assemble((text, style), (harmless(beside), "$quiet")))
        below = f"{len(rows)} of {len(self._all)}" if rows else "nothing is called so"
        body = Content("\n").join([*lines, Content.styled(below, "$quiet")])
        self.query_one(".rows", Static).update(body)
