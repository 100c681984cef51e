"""The card with the keys of the panel that has the focus, and those that work everywhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich.cells import cell_len
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.help import Entry, KeyList, section_lines


class KeyCard(KeyList):
    """A short list of keys; `?` replaces it by the list of all keys."""

    BINDINGS = [
        Binding("escape,q,enter", "close", "Close"),
        Binding("question_mark", "show_all", "All keys", priority=True),
    ]

    def __init__(
        self, title: str, list_entries: Callable[[], Sequence[Entry]], show_all: Callable[[], None]
    ) -> None:
        super().__init__(list_entries)
        self._card_title, self._show_all = title, show_all
        self._scroll, self._text = VerticalScroll(), Static()

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog card") as box:
            box.border_title = self._card_title
            box.border_subtitle = "? all keys   esc close"
            with self._scroll:
                yield self._text

    def on_mount(self) -> None:
        self.set_focus(self._scroll)

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
