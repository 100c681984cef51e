"""The dialog that lists the recordings of the black box."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical

from archo_tui.recording.listing import format_line
from archo_tui.recording.store import Recording
from archo_tui.screens.dialog import Dialog
from archo_tui.widgets.rows import Columns, Rows, Text


def recording_lines(recording: Recording, _width: int, _columns: Columns) -> list[Text]:
    """Return a row such as `2026-11-22_03-12-07_STOP   65 s    212 kB   STOP`."""
    return [(format_line(recording, len(recording.name)), "")]


class RecordingList(Dialog[None]):
    """A list in which enter copies the command that plays a recording, and d deletes one."""

    BINDINGS = [
        Binding("enter,y", "copy", "Copy the command", priority=True),
        Binding("d,delete", "delete", "Delete", priority=True),
        Binding("escape,q", "close", "Close"),
    ]

    def __init__(
        self,
        recordings: Sequence[Recording],
        copy: Callable[[Recording], None],
        delete: Callable[[Recording], None],
    ) -> None:
        """Create the dialog.

        Args:
            recordings: The newest first.
            copy: Copies the command that plays a recording.
            delete: Deletes a recording.
        """
        super().__init__()
        self._recordings, self._copy, self._delete = recordings, copy, delete
        self._rows: Rows[Recording] = Rows(
            recording_lines,
            lambda recording: recording.name,
            id="recordings",
            empty="No recordings.",
        )

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog reading") as box:
            box.border_title = "Recordings"
            box.border_subtitle = "enter copy the command that plays it   d delete   esc close"
            box.styles.height = max(len(self._recordings), 1) + 2  # Two for the border.
            yield self._rows

    def on_mount(self) -> None:
        self.set_focus(self._rows)
        self._rows.show_cursor()
        self.show_recordings(self._recordings)

    def show_recordings(self, recordings: Sequence[Recording]) -> None:
        """Replace the list, the newest first."""
        self._rows.show(recordings)

    def action_copy(self) -> None:
        """Copy the command that plays the recording under the cursor."""
        if self._rows.item is not None:
            self._copy(self._rows.item)

    def action_delete(self) -> None:
        """Delete the recording under the cursor."""
        if self._rows.item is not None:
            self._delete(self._rows.item)
