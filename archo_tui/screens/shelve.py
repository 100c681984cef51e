"""The dialog that asks why a high alarm is shelved, for the journal."""

from __future__ import annotations

from collections.abc import Callable

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Form
from archo_tui.station.alarm_board import SHELF_TIME
from archo_tui.station.alarms import Alarm


class ShelveReason(Form):
    """A dialog that asks why an alarm is shelved; escape leaves the alarm as it is."""

    submit_label = "Shelve"

    def __init__(self, alarm: Alarm, shelve: Callable[[str], None]) -> None:
        """Create the dialog; `shelve` gets the reason, stripped, not empty, before it closes."""
        super().__init__("reason")
        self._alarm, self._shelve = alarm, shelve

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = "Shelve"
            box.border_subtitle = "enter shelve   esc cancel"
            minutes = f"{SHELF_TIME / 60:.0f} min"
            yield Static(Content(f"{self._alarm.text}\n\nWhy is it silenced for {minutes}?"))
            yield self.field
            yield from self.below_field()

    def submit(self, typed: str) -> None:
        if typed.strip():
            self._shelve(typed.strip())
            self.dismiss()
        else:
            self.show_message("type a reason: it goes into the journal")
