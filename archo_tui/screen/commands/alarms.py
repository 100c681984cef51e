"""The commands of alarms and diagnostics, with their dialogs."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable
from typing import NamedTuple

from textual.binding import Binding

from archo_tui.robot.state.readings import Diagnostic, DiagnosticLevel
from archo_tui.screen.commands.base import Command, Desk
from archo_tui.screen.commands.request import AnswerRequest
from archo_tui.screen.dialog import Form, ListDialog
from archo_tui.screen.widgets.panel import ScreenState
from archo_tui.station.alarms import SHELF_TIME, Alarm, AlarmState, any_urgent, is_diagnostic
from archo_tui.station.conditions import Priority, diagnostics_worst_first
from archo_tui.station.view import View
from archo_tui.text.alarm import diagnostic_line, no_alarms_text, no_diagnostics_text, timeline
from archo_tui.text.columns import QUIET, Columns, Text
from archo_tui.verbs.show import ShowDiagnostics, forget


class ShowAlarms(Command):
    """The command that lists the alarms, or shows the request of an assistant if none is urgent."""

    id, key, verbs = "alarms", "A", ("alarms", "shelve")
    help = "List the alarms: acknowledge one or all, shelve one; or answer what an assistant asks"

    def run(self, desk: Desk) -> None:
        waiting = desk.station.approvals.waiting
        if waiting and not any_urgent(desk.view.alarms):  # Alarms of high priority come first.
            desk.open(AnswerRequest(desk, waiting[0]))
        else:
            desk.open(AlarmList(desk))


class ListDiagnostics(Command):
    in_replay = True
    id, verbs = "diagnostics", ("diagnostics", "forget")
    help = ShowDiagnostics.help

    def run(self, desk: Desk) -> None:
        desk.open(DiagnosticList(desk))


_INDENT = " " * 8
_SHELF = f"{SHELF_TIME / 60:.0f} min"


class AlarmRow(NamedTuple):
    """A row of the list: an alarm, and its text with the key of its remedy."""

    alarm: Alarm
    text: str


def alarm_lines(row: AlarmRow, width: int, _columns: Columns) -> list[Text]:
    """Return a row such as `HIGH    since 12:04:31, unacknowledged`, with text and advice below."""
    alarm = row.alarm
    style = {AlarmState.UNACKNOWLEDGED: "bold", AlarmState.SHELVED: QUIET}.get(alarm.state, "")
    head = f"{alarm.priority.value:<7} {timeline(alarm)}"
    text = textwrap.wrap(row.text, max(width - len(_INDENT), 20))
    return [(head, style), *((_INDENT + line, style) for line in text)]


class AlarmList(ListDialog[AlarmRow]):
    """The list of alarms: when each came and went, its state, and what to do."""

    # With priority, so that what is typed right after `s` goes into the field for the reason.
    BINDINGS = [
        Binding("a", "acknowledge", "Acknowledge", priority=True),
        Binding("A", "acknowledge_all", "Acknowledge all", priority=True),
        Binding("s", "shelve", "Shelve", priority=True),
        Binding("enter", "open_diagnostics", "Diagnostics"),
    ]

    keys_text = f"a acknowledge   A all   s shelve for {_SHELF} or unshelve   esc close"

    def __init__(self, desk: Desk) -> None:
        super().__init__("Alarms", alarm_lines, lambda row: row.alarm.name)
        self._desk = desk

    def on_mount(self) -> None:
        self.show_view(self._desk.view)

    def show_view(self, view: ScreenState) -> None:
        """Show the alarms of a new view."""
        rows = [AlarmRow(alarm, view.advice(alarm)) for alarm in view.alarms]
        self.show_items(rows, no_alarms_text(view.snapshot))

    def action_acknowledge(self) -> None:
        if self.rows.item is not None:
            self._acknowledge([self.rows.item.alarm])

    def action_acknowledge_all(self) -> None:
        """Acknowledge all alarms that are shown."""
        self._acknowledge([row.alarm for row in self.rows.items])

    def _acknowledge(self, alarms: Iterable[Alarm]) -> None:
        self._desk.station.acknowledge(alarms)
        self._desk.update_screen()

    def action_open_diagnostics(self) -> None:
        """List the robot's parts over this dialog, if the alarm under the cursor is about one."""
        row = self.rows.item
        if row is not None and is_diagnostic(row.alarm):
            self.app.push_screen(DiagnosticList(self._desk))

    def action_shelve(self) -> None:
        """Shelve the alarm under the cursor, asking why if it is a high one, or unshelve it."""
        if self.rows.item is None:
            return
        alarm = self.rows.item.alarm

        def shelve(reason: str) -> None:
            self._desk.station.shelve(alarm, reason)
            self._desk.update_screen()

        if alarm.priority == Priority.HIGH and alarm.state != AlarmState.SHELVED:
            self.app.push_screen(ShelveReason(alarm, shelve))
        else:
            shelve("")


class ShelveReason(Form):
    """A dialog that asks why an alarm is shelved, for the journal."""

    submit_label = "Shelve"

    def __init__(self, alarm: Alarm, shelve: Callable[[str], None]) -> None:
        """Create the dialog; `shelve` gets the reason, stripped, not empty, before it closes."""
        text = f"{alarm.text}\n\nWhy is it silenced for {_SHELF}?"
        super().__init__("reason", title="Shelve", text=text)
        self._shelve = shelve

    def submit(self, typed: str) -> None:
        if typed.strip():
            self._shelve(typed.strip())
            self.dismiss()
        else:
            self.show_message("type a reason: it goes into the journal")


class _Part(NamedTuple):
    status: Diagnostic
    text: str


class DiagnosticList(ListDialog[_Part]):
    """A list of the robot's parts, the worst first, which changes with the robot's reports."""

    BINDINGS = [
        Binding("f", "forget", "Forget", priority=True),
        Binding("enter", "close", "Close"),
    ]

    def __init__(self, desk: Desk) -> None:
        super().__init__("Diagnostics", _part_lines, lambda part: part.status.key)
        self._desk = desk

    def on_mount(self) -> None:
        self.show_view(self._desk.view)

    def show_view(self, view: View) -> None:
        """Show the parts of a new view."""
        parts = diagnostics_worst_first(view.snapshot, view.now)
        rows = [_Part(status, diagnostic_line(status, view.now)) for status in parts]
        self.show_items(rows, no_diagnostics_text(view.snapshot))
        is_any_gone = any(status.is_gone_at(view.now) for status in parts)
        keys = "f forget a silent part   " if is_any_gone else ""
        self.box.border_subtitle = f"{keys}esc close"

    def action_forget(self) -> None:
        """Forget the part under the cursor."""
        if self.rows.item is not None:
            self._desk.report_failure(forget(self._desk.station, self.rows.item.status))


def _part_lines(part: _Part, width: int, _columns: Columns) -> list[Text]:
    style = {DiagnosticLevel.OK: QUIET, DiagnosticLevel.ERROR: "bold"}.get(part.status.level, "")
    wrapped = textwrap.wrap(part.text, max(width, 20), subsequent_indent=_INDENT)
    return [(line, style) for line in wrapped]
