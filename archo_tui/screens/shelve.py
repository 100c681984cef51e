"""Asks why a grave alarm is silenced: the reason goes into the journal."""

from __future__ import annotations

from collections.abc import Callable

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Form
from archo_tui.station.alarms import SHELF_TIME, Alarm


class ShelveReason(Form):
    """`shelve(reason)` is called with what was typed; escape leaves the alarm as it is."""

    does = "Shelve"

    def __init__(self, alarm: Alarm, shelve: Callable[[str], None]) -> None:
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
            self.say("type a reason: it goes into the journal")
