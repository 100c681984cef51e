"""A field that narrows the list above it; not there until it is opened."""

from __future__ import annotations

from collections.abc import Callable

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.widget import Widget

from archo_tui.robot.text import harmless
from archo_tui.widgets.field import Field


class SearchLine(Horizontal):
    """`/ brake   2 of 14`: the field, and how much it leaves; not there until it is opened."""

    DEFAULT_CSS = """
        SearchLine { display: none; height: 1; dock: bottom; }
        SearchLine Field { width: 1fr; margin: 0 15 0 2; }
    """

    def __init__(self, search: Search) -> None:
        super().__init__()
        self._search = search
        self._count = ""

    def compose(self) -> ComposeResult:
        yield self._search

    def render(self) -> Content:
        """What stands around the field."""
        room = max(self.size.width - 1, len(self._count))
        return Content.assemble("/", (f"{self._count:>{room}}", "$quiet"))

    def count(self, shown: int, total: int) -> None:
        """Show how many rows the search leaves, of how many."""
        count = f"{shown} of {total}"
        if count != self._count:
            self._count = count
            self.refresh()


class Search(Field):
    """`/` opens it, enter leaves it and keeps the filter, escape takes both away."""

    def __init__(self, target: Widget, changed: Callable[[], object]) -> None:
        super().__init__(placeholder="type to search", changed=changed, submitted=self._leave)
        self._target = target
        self.line = SearchLine(self)

    def open(self) -> None:
        """Show it and type into it."""
        self._show(True)
        self.screen.set_focus(self)

    @property
    def wanted(self) -> str:
        """What rows must contain, harmless to show; empty: all of them are shown."""
        return harmless(self.value.strip())

    def narrowed(self, shown: int, total: int) -> str:
        """Return `/ brake: 2 of 14` for the panel's title, empty when nothing is searched for."""
        self.line.count(shown, total)
        return f"/ {self.wanted}: {shown} of {total}" if self.wanted else ""

    def close(self) -> None:
        """Show everything again."""
        self.clear()
        self._leave()

    def _leave(self) -> None:
        self._show(bool(self.value))
        self.screen.set_focus(self._target)

    def _show(self, is_open: bool) -> None:
        self.line.display = is_open
        for panel in self.line.ancestors:
            if panel.has_class("panel"):  # a low one gets more rows, else nothing found is seen
                self.screen.set_class(is_open, f"-search-{panel.id}")

    def matches(self, *texts: str) -> bool:
        """True when one of the texts has the letters in it, small or capital."""
        wanted = self.value.strip().casefold()
        return not wanted or any(wanted in text.casefold() for text in texts)
