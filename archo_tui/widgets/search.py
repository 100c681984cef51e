"""A search field that narrows the list above it, hidden until it is opened."""

from __future__ import annotations

from collections.abc import Callable

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.widget import Widget

from archo_tui.safe_text import harmless
from archo_tui.widgets.field import Field


class SearchLine(Horizontal):
    """The line `/ brake   2 of 14` below a list, hidden unless its search is open or has a text."""

    DEFAULT_CSS = """
        SearchLine { display: none; height: 1; dock: bottom; }
        SearchLine Field { width: 1fr; margin: 0 15 0 2; }
    """

    def __init__(self, search: Search) -> None:
        super().__init__()
        self._search = search
        self._count_text = ""

    def compose(self) -> ComposeResult:
        yield self._search

    def render(self) -> Content:
        """Return the `/` and the count; the field is drawn between them."""
        room = max(self.size.width - 1, len(self._count_text))
        return Content.assemble("/", (f"{self._count_text:>{room}}", "$quiet"))

    def show_count(self, shown: int, total: int) -> None:
        """Show `2 of 14` at the right end."""
        count = f"{shown} of {total}"
        if count != self._count_text:
            self._count_text = count
            self.refresh()


class Search(Field):
    """The search field of a list: enter keeps the filter, escape clears it; both focus the list."""

    keys = ("enter", "Keep filter"), ("esc", "Clear")

    def __init__(self, target: Widget, changed: Callable[[], object]) -> None:
        super().__init__(placeholder="type to search", changed=changed, submitted=self._leave)
        self._target = target
        self.line = SearchLine(self)  # For the panel to compose.

    def open(self) -> None:
        """Show the field with the text of the last search, and focus it."""
        self._show(True)
        self.screen.set_focus(self)

    @property
    def search_text(self) -> str:
        """Return the typed text, stripped and safe to print; "" if rows are not narrowed."""
        return harmless(self.value.strip())

    def show_count(self, shown: int, total: int) -> str:
        """Show `2 of 14` beside the field; return `/ brake: 2 of 14`, or "" if nothing is typed."""
        self.line.show_count(shown, total)
        return f"/ {self.search_text}: {shown} of {total}" if self.search_text else ""

    def close(self) -> None:
        """Clear the text, hide the field, and focus the list."""
        self.clear()
        self._leave()

    def _leave(self) -> None:
        self._show(bool(self.value))
        self.screen.set_focus(self._target)

    def _show(self, is_open: bool) -> None:
        self.line.display = is_open

    def matches(self, *texts: str) -> bool:
        """Return True if nothing is typed, or one of the texts contains it, in any case."""
        wanted = self.value.strip().casefold()
        return not wanted or any(wanted in text.casefold() for text in texts)
