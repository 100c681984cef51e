"""The line with a field for the index of an element of an open array."""

from __future__ import annotations

from collections.abc import Callable

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content

from archo_tui.text.topic import element_index, element_range
from archo_tui.widgets.field import Field

_HINT_AT = 21  # Cells of the line before its text: the word, and the field.


class ElementLine(Horizontal):
    """The line `element 137  of ranges: 0 ..

    359`, in which enter goes to an element of an array.
    """

    DEFAULT_CSS = """
        ElementLine { display: none; height: 1; }
        ElementLine Field { width: 12; margin: 0 0 0 8; }
    """

    def __init__(self, go: Callable[[str, int], object]) -> None:
        super().__init__()
        self.array = ""  # Its path; "" while the line is hidden.
        self._length = 0
        self._go = go
        self.field = Field(id="element", changed=self._show_range, submitted=self._submit)
        self._hint = Content("")

    def compose(self) -> ComposeResult:
        yield self.field

    def render(self) -> Content:
        """Return `element` and the range or the error, with a gap over which the field is drawn."""
        return Content.assemble(f"{'element':<{_HINT_AT}}", self._hint)

    def open(self, array: str, length: int) -> None:
        """Show the line for the array at a path, with an empty field that gets the focus."""
        self.array, self._length = array, length
        self.field.clear()
        self._show_range()
        self.display = True
        self.screen.set_focus(self.field)

    def close(self) -> None:
        """Hide the line, and set `array` to ""; the focus is left where it is."""
        self.array = ""
        self.display = False

    def set_length(self, length: int) -> None:
        """Show the range for a new length; an unchanged one keeps an error."""
        if length != self._length:
            self._length = length
            self._show_range()

    def _show_range(self) -> None:
        self._show_hint(f"of {element_range(self.array, self._length)}", "$quiet")

    def _show_hint(self, text: str, style: str) -> None:
        hint = Content.styled(text, style)
        if not hint.is_same(self._hint):
            self._hint = hint
            self.refresh()

    def _submit(self) -> None:
        try:
            index = element_index(self.field.value, self.array, self._length)
        except ValueError as error:
            self._show_hint(str(error), "bold $bad")
        else:
            self._go(self.array, index)
