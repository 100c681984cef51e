"""The list of alarms: when each came and went, what to do, and whether somebody has seen it."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical

from archo_tui.screens.dialog import Dialog
from archo_tui.screens.shelve import ShelveReason
from archo_tui.station.alarms import SHELF_TIME, Alarm, AlarmState, Priority
from archo_tui.station.station import View
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text
from archo_tui.words.alarm import no_alarms_text, timeline

_INDENT = " " * 8


def alarm_lines(alarm: Alarm, width: int, _columns: Columns) -> list[Text]:
    """`✗ HIGH  since 12:04:31, unacknowledged`, and what to do below."""
    style = {AlarmState.UNACKNOWLEDGED: "bold", AlarmState.SHELVED: QUIET}.get(alarm.state, "")
    head = f"{alarm.priority.value:<7} {timeline(alarm)}"
    text = textwrap.wrap(alarm.text, max(width - len(_INDENT), 20))
    return [(head, style), *((_INDENT + line, style) for line in text)]


class AlarmList(Dialog[None]):
    """Acknowledge one or all, shelve one for a while; escape closes it."""

    BINDINGS = [  # with priority: what is typed behind `s` is the reason
        Binding("a", "acknowledge", "Acknowledge", priority=True),
        Binding("A", "acknowledge_all", "Acknowledge all", priority=True),
        Binding("s", "shelve", "Shelve", priority=True),
        Binding("escape,q", "close", "Close"),
    ]

    def __init__(
        self,
        view: View,
        acknowledge: Callable[[Iterable[Alarm]], None],
        shelve: Callable[[Alarm, str], None],
        changed: Callable[[], None],
    ) -> None:
        """`changed()` is called after something was acknowledged or shelved."""
        super().__init__()
        self._view, self._acknowledge, self._shelve = view, acknowledge, shelve
        self._changed = changed
        self._box = Vertical(classes="dialog reading")
        self._rows: Rows[Alarm] = Rows(
            alarm_lines,
            lambda alarm: alarm.name,
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
        self.follow(self._view)

    def follow(self, view: View) -> None:
        """Show what there is now."""
        self._view = view
        self._rows.empty = no_alarms_text(view.snapshot)
        self._rows.show(view.alarms)
        self._box.styles.height = max(self._rows.virtual_size.height, 1) + 2  # with its border

    def action_acknowledge(self) -> None:
        """The selected one has been seen."""
        if self._rows.item is not None:
            self._acknowledge([self._rows.item])
            self._changed()

    def action_acknowledge_all(self) -> None:
        """All that are shown have been seen."""
        self._acknowledge(self._view.alarms)
        self._changed()

    def action_shelve(self) -> None:
        """Silence the selected one for a while, or no longer; of a grave one it asks why."""
        alarm = self._rows.item
        if alarm is None:
            return

        def shelve(reason: str) -> None:
            self._shelve(alarm, reason)
            self._changed()

        if alarm.priority == Priority.HIGH and alarm.state != AlarmState.SHELVED:
            self.app.push_screen(ShelveReason(alarm, shelve))
        else:
            shelve("")
