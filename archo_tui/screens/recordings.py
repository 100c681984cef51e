"""The dialog that lists the recordings of the black box."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from datetime import datetime
from functools import partial

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical

from archo_tui.recordings.store import Recording, length_size_and_why
from archo_tui.screens.dialog import Dialog
from archo_tui.terminal.app import start_worker
from archo_tui.widgets.rows import Columns, Rows, Text, crop


def recording_lines(recording: Recording, width: int, _columns: Columns) -> list[Text]:
    """Return `2026-11-22 03:12:07     65 s      212 kB  STOP, kept`, in local time."""
    when = f"{datetime.fromtimestamp(recording.start):%Y-%m-%d %H:%M:%S}"
    return [(crop(f"{when}  {length_size_and_why(recording)}", width), "")]


class RecordingList(Dialog[None]):
    """A list of recordings: enter plays one, y copies the command that plays it, d deletes it."""

    BINDINGS = [
        Binding("enter", "play", "Play", priority=True),
        Binding("y", "copy", "Copy the command", priority=True),
        Binding("d,delete", "delete", "Delete", priority=True),
        Binding("escape,q", "close", "Close"),
    ]

    def __init__(
        self,
        recordings: Sequence[Recording],  # The newest first.
        # Opens a recording; keys wait until that ends.
        play: Callable[[Recording], Awaitable[None]],
        copy: Callable[[Recording], None],  # Copies the command that plays it.
        delete: Callable[[Recording], None],  # May ask first.
    ) -> None:
        super().__init__()
        self._recordings, self._play, self._copy, self._delete = recordings, play, copy, delete
        self._rows: Rows[Recording] = Rows(
            recording_lines,
            lambda recording: recording.name,
            id="recordings",
            action="screen.play",
            empty="No recordings.",
        )

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog reading") as box:
            box.border_title = "Recordings"
            box.border_subtitle = "enter play   y copy the command   d delete   esc close"
            box.styles.height = max(len(self._recordings), 1) + 2  # Two for the border.
            yield self._rows

    def on_mount(self) -> None:
        self.set_focus(self._rows)
        self._rows.show_cursor()
        self.show_recordings(self._recordings)

    def show_recordings(self, recordings: Sequence[Recording]) -> None:
        """Show other recordings, the newest first, in place of those before."""
        self._rows.show(recordings)

    def action_play(self) -> None:
        """Open the recording under the cursor; keys wait, and a second call is ignored."""
        if self._rows.item is not None and not self.is_asking:
            self.is_asking = True
            start_worker(self.app, partial(self._wait_for, self._rows.item), "replay")

    async def _wait_for(self, recording: Recording) -> None:
        try:
            await self._play(recording)
        finally:
            self.is_asking = False

    def action_copy(self) -> None:
        """Copy the command that plays the recording under the cursor; nothing without one."""
        if self._rows.item is not None:
            self._copy(self._rows.item)

    def action_delete(self) -> None:
        """Pass the recording under the cursor to `delete`; nothing happens without one."""
        if self._rows.item is not None:
            self._delete(self._rows.item)
