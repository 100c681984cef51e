"""A field that narrows the list above it; not there until it is opened."""

from __future__ import annotations

from textual.widget import Widget

from archo_tui.widgets.field import Field


class Search(Field):
    """`/` opens it, enter leaves it and keeps the filter, escape takes both away."""

    DEFAULT_CSS = "Search { display: none; } Search.-open { display: block; }"

    def __init__(self, target: Widget) -> None:
        super().__init__(placeholder="type to search")
        self.add_class("search")
        self._target = target

    def open(self) -> None:
        """Show it and type into it."""
        self.add_class("-open")
        self.screen.set_focus(self)

    def close(self) -> None:
        """Show everything again."""
        self.clear()
        self._leave()

    def on_input_submitted(self) -> None:
        self._leave()

    def _leave(self) -> None:
        self.set_class(bool(self.value), "-open")
        self.screen.set_focus(self._target)

    def matches(self, *texts: str) -> bool:
        """True when one of the texts has the letters in it, small or capital."""
        wanted = self.value.strip().casefold()
        return not wanted or any(wanted in text.casefold() for text in texts)
