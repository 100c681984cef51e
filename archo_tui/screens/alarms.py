"""The dialog that lists the alarms: when each came and went, its state, and what to do."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable
from typing import NamedTuple

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical

from archo_tui.robot.state.readings import Diagnostic
from archo_tui.screens.diagnostics import DiagnosticList
from archo_tui.screens.dialog import Dialog
from archo_tui.screens.shelve import ShelveReason
from archo_tui.station.alarm_board import SHELF_TIME
from archo_tui.station.alarms import Alarm, AlarmState, Priority, is_diagnostic
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text
from archo_tui.widgets.screen_state import ScreenState
from archo_tui.words.alarm import no_alarms_text, timeline

_INDENT = " " * 8


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


class AlarmList(Dialog[None]):
    """The list of alarms: `a` acknowledges one, `A` all, `s` shelves one.

    Escape closes the list.
    """

    # With priority, so that what is typed right after `s` goes into the field for the reason.
    BINDINGS = [
        Binding("a", "acknowledge", "Acknowledge", priority=True),
        Binding("A", "acknowledge_all", "Acknowledge all", priority=True),
        Binding("s", "shelve", "Shelve", priority=True),
        Binding("enter", "open_diagnostics", "Diagnostics"),
        Binding("escape,q", "close", "Close"),
    ]

    def __init__(
        self,
        view: ScreenState,
        acknowledge: Callable[[Iterable[Alarm]], None],
        # With a reason (may be ""), or unshelves a shelved one.
        shelve: Callable[[Alarm, str], None],
        # Called after something was acknowledged, shelved or unshelved.
        on_change: Callable[[], None],
        forget: Callable[[Diagnostic], None],  # Or says why not.
    ) -> None:
        super().__init__()
        self._view, self._acknowledge, self._shelve = view, acknowledge, shelve
        self._on_change, self._forget = on_change, forget
        self._box = Vertical(classes="dialog reading")
        self._rows: Rows[AlarmRow] = Rows(
            alarm_lines,
            lambda row: row.alarm.name,
            id="alarms",
            empty="",
            wraps=True,
        )

    def body(self) -> ComposeResult:
        with self._box:
            self._box.border_title = "Alarms"
            minutes = SHELF_TIME / 60
            keys = f"a acknowledge   A all   s shelve for {minutes:.0f} min or unshelve   esc close"
            self._box.border_subtitle = keys
            yield self._rows

    def on_mount(self) -> None:
        self.set_focus(self._rows)
        self.show_view(self._view)

    def show_view(self, view: ScreenState) -> None:
        """Show the alarms of a new view, and fit the height of the box to them."""
        self._view = view
        self._rows.empty = no_alarms_text(view.snapshot)
        self._rows.show([AlarmRow(alarm, view.advice(alarm)) for alarm in view.alarms])
        self._box.styles.height = max(self._rows.virtual_size.height, 1) + 2  # Two for the border.

    def action_acknowledge(self) -> None:
        if self._rows.item is not None:
            self._acknowledge([self._rows.item.alarm])
            self._on_change()

    def action_acknowledge_all(self) -> None:
        """Acknowledge all alarms that are shown."""
        self._acknowledge(self._view.alarms)
        self._on_change()

    def action_open_diagnostics(self) -> None:
        """List the robot's parts over this dialog, if the alarm under the cursor is about one."""
        row = self._rows.item
        if row is not None and is_diagnostic(row.alarm):
            self.app.push_screen(DiagnosticList(self._view, self._forget))

    def action_shelve(self) -> None:
        """Shelve the alarm under the cursor, asking why if it is a high one, or unshelve it."""
        if self._rows.item is None:
            return
        alarm = self._rows.item.alarm

        def shelve(reason: str) -> None:
            self._shelve(alarm, reason)
            self._on_change()

        if alarm.priority == Priority.HIGH and alarm.state != AlarmState.SHELVED:
            self.app.push_screen(ShelveReason(alarm, shelve))
        else:
            shelve("")
