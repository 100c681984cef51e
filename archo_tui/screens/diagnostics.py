"""The dialog that lists what the robot reports of its parts, the worst first."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from typing import NamedTuple

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical

from archo_tui.robot.state.readings import Diagnostic, DiagnosticLevel
from archo_tui.screens.dialog import Dialog
from archo_tui.station.conditions import diagnostics_worst_first
from archo_tui.station.view import View
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text
from archo_tui.words.diagnostics import diagnostic_line, no_diagnostics_text


class _Part(NamedTuple):
    status: Diagnostic
    text: str


class DiagnosticList(Dialog[None]):
    """A list of the robot's parts, the worst first, which changes with the robot's reports."""

    BINDINGS = [
        Binding("f", "forget", "Forget", priority=True),
        Binding("escape,enter,q", "close", "Close"),
    ]

    def __init__(self, view: View, forget: Callable[[Diagnostic], None]) -> None:
        super().__init__()
        self._view, self._forget = view, forget
        self._box = Vertical(classes="dialog reading")
        self._rows: Rows[_Part] = Rows(
            _lines, lambda part: part.status.key, id="diagnostics", empty="", wraps=True
        )

    def body(self) -> ComposeResult:
        with self._box:
            self._box.border_title = "Diagnostics"
            yield self._rows

    def on_mount(self) -> None:
        self.set_focus(self._rows)
        self.show_view(self._view)

    def show_view(self, view: View) -> None:
        """Show the parts of a new view, and fit the height of the box to them."""
        self._rows.empty = no_diagnostics_text(view.snapshot)
        parts = diagnostics_worst_first(view.snapshot, view.now)
        self._rows.show([_Part(status, diagnostic_line(status, view.now)) for status in parts])
        is_any_gone = any(status.is_gone_at(view.now) for status in parts)
        keys = "f forget a silent part   " if is_any_gone else ""
        self._box.border_subtitle = f"{keys}esc close"
        self._box.styles.height = max(self._rows.virtual_size.height, 1) + 2  # Two for the border.

    def action_forget(self) -> None:
        """Forget the part under the cursor."""
        if self._rows.item is not None:
            self._forget(self._rows.item.status)


def _lines(part: _Part, width: int, _columns: Columns) -> list[Text]:
    style = {DiagnosticLevel.OK: QUIET, DiagnosticLevel.ERROR: "bold"}.get(part.status.level, "")
    wrapped = textwrap.wrap(part.text, max(width, 20), subsequent_indent=" " * 8)
    return [(line, style) for line in wrapped]
