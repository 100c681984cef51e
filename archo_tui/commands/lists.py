"""The dialogs that list alarms, the robot's parts, and the recordings of the black box."""

from __future__ import annotations

import asyncio
import textwrap
from collections.abc import Callable, Iterable, Sequence
from datetime import datetime
from functools import partial
from typing import TYPE_CHECKING, ClassVar, Generic, NamedTuple, TypeVar

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical

from archo_tui.clock import Clock
from archo_tui.commands.base import Desk
from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError, in_one_line
from archo_tui.recordings import store
from archo_tui.recordings.store import Recording, length_size_and_why
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.readings import Diagnostic, DiagnosticLevel
from archo_tui.screens.dialog import Dialog, Form
from archo_tui.station.alarms import SHELF_TIME, Alarm, AlarmState, is_diagnostic
from archo_tui.station.conditions import Priority, diagnostics_worst_first
from archo_tui.station.view import View
from archo_tui.terminal.app import start_worker
from archo_tui.text.alarm import no_alarms_text, timeline
from archo_tui.text.diagnostics import diagnostic_line, no_diagnostics_text
from archo_tui.text.frames import transform_lines
from archo_tui.verbs.show import forget
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text, crop
from archo_tui.widgets.screen_state import ScreenState

if TYPE_CHECKING:
    from archo_tui.recordings.replay.player import Player

T = TypeVar("T")
_INDENT = " " * 8
_SHELF = f"{SHELF_TIME / 60:.0f} min"


class ListDialog(Dialog[None], Generic[T]):
    """The base of dialogs with a list, which are as high as its rows."""

    BINDINGS = [Binding("escape,q", "close", "Close")]

    keys_text: ClassVar[str] = "esc close"  # On the lower border.

    def __init__(self, title: str, rows: Rows[T]) -> None:
        super().__init__()
        self.title, self.rows = title, rows
        self.box = Vertical(rows, classes="dialog reading")

    def body(self) -> ComposeResult:
        self.box.border_title, self.box.border_subtitle = self.title, self.keys_text
        yield self.box

    def on_mount(self) -> None:
        self.set_focus(self.rows)

    def show_items(self, items: Sequence[T]) -> None:
        """Show other items in place of those before."""
        self.rows.show(items)
        self.box.styles.height = max(self.rows.virtual_size.height, 1) + 2  # Two for the border.


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
        rows: Rows[AlarmRow] = Rows(
            alarm_lines, lambda row: row.alarm.name, id="alarms", empty="", wraps=True
        )
        super().__init__("Alarms", rows)
        self._desk = desk

    def on_mount(self) -> None:
        self.show_view(self._desk.view)

    def show_view(self, view: ScreenState) -> None:
        """Show the alarms of a new view."""
        self.rows.empty = no_alarms_text(view.snapshot)
        self.show_items([AlarmRow(alarm, view.advice(alarm)) for alarm in view.alarms])

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
        rows: Rows[_Part] = Rows(
            _part_lines, lambda part: part.status.key, id="diagnostics", empty="", wraps=True
        )
        super().__init__("Diagnostics", rows)
        self._desk = desk

    def on_mount(self) -> None:
        self.show_view(self._desk.view)

    def show_view(self, view: View) -> None:
        """Show the parts of a new view."""
        self.rows.empty = no_diagnostics_text(view.snapshot)
        parts = diagnostics_worst_first(view.snapshot, view.now)
        self.show_items([_Part(status, diagnostic_line(status, view.now)) for status in parts])
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


class FrameList(ListDialog[str]):
    """A list of the transforms, which are received while it is open; it changes each second."""

    def __init__(self, desk: Desk) -> None:
        rows: Rows[str] = Rows(
            lambda line, width, _: [(part, "") for part in textwrap.wrap(line, max(width, 20))],
            lambda line: line.partition(":")[0],
            id="transforms",
            empty="",
            wraps=True,
        )
        super().__init__("Transforms", rows)
        self._desk = desk

    def on_mount(self) -> None:
        self.show_view(self._desk.view)
        start_worker(self, self._receive, "transforms")

    async def _receive(self) -> None:
        async with self._desk.station.robot.listen_to_frames():
            await asyncio.Event().wait()  # It is cancelled when the dialog closes.

    def show_view(self, view: View) -> None:
        """Show the transforms of a new view."""
        self.show_items(transform_lines(view.snapshot.transforms, view.now))


def recording_lines(recording: Recording, width: int, _columns: Columns) -> list[Text]:
    """Return `2026-11-22 03:12:07     65 s      212 kB  STOP, kept`, in local time."""
    when = f"{datetime.fromtimestamp(recording.start):%Y-%m-%d %H:%M:%S}"
    return [(crop(f"{when}  {length_size_and_why(recording)}", width), "")]


class RecordingList(ListDialog[Recording]):
    """A list of recordings: enter plays one, y copies the command that plays it, d deletes it."""

    BINDINGS = [
        Binding("enter", "play", "Play", priority=True),
        Binding("y", "copy", "Copy the command", priority=True),
        Binding("d,delete", "delete", "Delete", priority=True),
    ]

    keys_text = "enter play   y copy the command   d delete   esc close"

    def __init__(self, desk: Desk, recordings: Sequence[Recording]) -> None:
        """Create the list; the newest recording comes first."""
        rows: Rows[Recording] = Rows(
            recording_lines,
            lambda recording: recording.name,
            id="recordings",
            action="screen.play",
            empty="No recordings.",
        )
        super().__init__("Recordings", rows)
        self._desk, self._recordings = desk, recordings

    def on_mount(self) -> None:
        self.rows.show_cursor()
        self.show_items(self._recordings)

    def action_play(self) -> None:
        """Open the recording under the cursor; keys wait, and a second call is ignored."""
        if self.rows.item is not None and not self.is_asking:
            self.is_asking = True
            start_worker(self.app, partial(self._play, self.rows.item), "replay")

    async def _play(self, recording: Recording) -> None:
        """Load a recording on another thread; show it in place of the list, or say why not."""
        try:
            player = await in_daemon(_open, recording, self._desk.station.clock)
        except ArchoError as error:
            said = str(error)
        except Exception as error:  # A damaged file may raise anything; the live console goes on.
            said = f"{recording.name}: {in_one_line(error)}"
        else:
            if self.is_active and not self.is_dismissed:
                self.dismiss()
                self._desk.live.begin_replay(player)
                return
            player.close()
            said = "another dialog was opened meanwhile"
        finally:
            self.is_asking = False
        if not self.is_dismissed:
            self._refuse(f"not played: {said}")

    def _refuse(self, text: str) -> None:
        self._desk.report_failure(Outcome(Code.REFUSED, text))

    def action_copy(self) -> None:
        """Copy the command that plays the recording under the cursor; nothing without one."""
        if self.rows.item is not None:
            command = f"archo-tui replay {self.rows.item.name}"
            self._desk.live.copy_to_clipboard(command)
            self._desk.show_message(command, title="Copied the command")

    def action_delete(self) -> None:
        """Ask, and delete the recording under the cursor; nothing happens without one."""
        if self.rows.item is not None:
            name = self.rows.item.name
            answers = {"Delete": partial(self._delete, self.rows.item)}
            question = f"Delete {name}? It is gone then."
            self._desk.live.confirm("Delete a recording", question, "Keep it", answers)

    async def _delete(self, recording: Recording) -> None:
        try:
            await in_daemon(store.delete, recording)
        except OSError as error:
            self._refuse(f"not deleted: {error.strerror or error}")
        else:
            note = f"recording {recording.name} deleted"
            self._desk.station.robot.note("YOU", "console", note)
        found = await list_recordings(self._desk)
        if found is not None and not self.is_dismissed:
            self.show_items(found)


def _open(recording: Recording, clock: Clock) -> Player:
    from archo_tui.recordings.replay.player import load_robot_file, make_player, open_bag

    bag = open_bag(str(recording.folder))
    return make_player(bag, load_robot_file(bag, ""), clock)


async def list_recordings(desk: Desk) -> list[Recording] | None:
    """Return the recordings, newest first, or None after showing why they cannot be read."""
    try:
        return await in_daemon(store.own_recordings)
    except ArchoError as error:
        desk.report_failure(Outcome(Code.REFUSED, str(error)))
        return None
