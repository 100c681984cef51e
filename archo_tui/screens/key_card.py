"""The card with the keys of the panel that has the focus, and those that work everywhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Dialog
from archo_tui.screens.help import Entry, section_lines
from archo_tui.station.view import View


class KeyCard(Dialog[None]):
    """A short list of keys; `?` leads from it to the list of all."""

    BINDINGS = [
        Binding("escape,q,enter", "close", "Close"),
        Binding("question_mark", "show_all", "All keys", priority=True),
    ]

    def __init__(
        self, title: str, list_entries: Callable[[], Sequence[Entry]], show_all: Callable[[], None]
    ) -> None:
        """Create the card.

        Args:
            title: The title of the box.
            list_entries: Returns the keys; called again while the card is open, since some that
                work now may not work later.
            show_all: Opens the list of all keys.
        """
        super().__init__()
        self._card_title, self._list_entries, self._show_all = title, list_entries, show_all
        self._entries = list_entries()
        self._scroll, self._text = VerticalScroll(), Static()

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog card") as box:
            box.border_title = self._card_title
            box.border_subtitle = "? all keys   esc close"
            with self._scroll:
                yield self._text

    def on_mount(self) -> None:
        self.set_focus(self._scroll)

    def on_resize(self) -> None:
        self.call_after_refresh(self._draw)

    def show_view(self, view: View) -> None:
        """Show which of the keys work now."""
        entries = self._list_entries()
        if entries != self._entries:
            self._entries = entries
            self._draw()

    def action_show_all(self) -> None:
        """Close the card and open the list of all keys."""
        self.dismiss()
        self._show_all()

    def _draw(self) -> None:
        key_width = max((cell_len(entry.key) for entry in self._entries), default=0)
        width = self._scroll.size.width - 1
        blocks = section_lines(self._entries, width, key_width)
        lines = [line for block in blocks for line in block]
        self._text.update(Content("\n").join(lines[1:]))  # The first line is blank.
