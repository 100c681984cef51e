"""The list of recordings."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from functools import partial

from textual.binding import Binding

from archo_tui.commands.base import Command, Desk, Work
from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.recordings import store
from archo_tui.recordings.store import Recording, length_size_and_why
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screens.dialog import ListDialog
from archo_tui.text.columns import Columns, Text, crop
from archo_tui.widgets.rows import Rows


class ShowRecordings(Command):
    id = "recordings"
    help = "List the recordings: when, why, how long; copy the command that plays one, delete one"

    def run(self, desk: Desk) -> Work:
        return self._show(desk)

    async def _show(self, desk: Desk) -> None:
        with desk.opening():
            found = await list_recordings(desk)
        if found is not None:
            desk.open(RecordingList(desk, found))


def recording_lines(recording: Recording, width: int, _columns: Columns) -> list[Text]:
    """Return `2026-11-22 03:12:07     65 s      212 kB  STOP, kept`, in local time."""
    when = f"{datetime.fromtimestamp(recording.start):%Y-%m-%d %H:%M:%S}"
    return [(crop(f"{when}  {length_size_and_why(recording)}", width), "")]


class RecordingList(ListDialog[Recording]):
    """A list of recordings: enter copies the command that plays one, d deletes it."""

    BINDINGS = [
        Binding("enter,y", "copy", "Copy the command that plays it", priority=True),
        Binding("d,delete", "delete", "Delete", priority=True),
    ]

    keys_text = "enter copy the command that plays it   d delete   esc close"

    def __init__(self, desk: Desk, recordings: Sequence[Recording]) -> None:
        """Create the list; the newest recording comes first."""
        rows: Rows[Recording] = Rows(
            recording_lines,
            lambda recording: recording.name,
            id="recordings",
            action="screen.copy",
            empty="No recordings.",
        )
        super().__init__("Recordings", rows)
        self._desk, self._recordings = desk, recordings

    def on_mount(self) -> None:
        self.rows.show_cursor()
        self.show_items(self._recordings)

    def _refuse(self, text: str) -> None:
        self._desk.report_failure(Outcome(Code.REFUSED, text))

    def action_copy(self) -> None:
        """Copy the command that plays the recording under the cursor; nothing without one."""
        if self.rows.item is not None:
            command = f"archo-tui replay {self.rows.item.name}"
            self._desk.copy_to_clipboard(command)
            self._desk.show_message(f"{command}: run it in another terminal", title="Copied")

    def action_delete(self) -> None:
        """Ask, and delete the recording under the cursor; nothing happens without one."""
        if self.rows.item is not None:
            name = self.rows.item.name
            answers = {"Delete": partial(self._delete, self.rows.item)}
            question = f"Delete {name}? It is gone then."
            self._desk.confirm("Delete a recording", question, "Keep it", answers)

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


async def list_recordings(desk: Desk) -> list[Recording] | None:
    """Return the recordings, newest first, or None after showing why they cannot be read."""
    try:
        return await in_daemon(store.own_recordings)
    except ArchoError as error:
        desk.report_failure(Outcome(Code.REFUSED, str(error)))
        return None
