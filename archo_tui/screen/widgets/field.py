"""The input field, the search and the button of all panels and dialogs, which act at once."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, cast

from textual import events, widgets
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal
from textual.content import Content
from textual.geometry import Size
from textual.reactive import Reactive
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Input

from archo_tui.base.safe_text import harmless

INTEGER = "-0123456789 "  # The characters of one or several whole numbers.
NUMBER = f"{INTEGER}.+"


class Field(Input, inherit_css=False):
    """An input of one line that handles keys and pastes at once, and reports changes by calls.

    Textual's own handles each key by messages: of keys typed fast, those behind an enter would
    arrive before anybody knew that something was entered.
    """

    COMPONENT_CLASSES = {"input--cursor", "input--placeholder", "input--selection"}
    BINDINGS = [Binding("up", "step(-1)", show=False), Binding("down", "step(1)", show=False)]

    # Unlike in Textual, a change does not lay out the whole screen: a field never grows.
    virtual_size = Reactive(Size(0, 0))
    next_field: Field | None = None  # Where enter leads; None for the last one of the form.
    keys: tuple[tuple[str, str], ...] = ()  # Keys of the field, each with its word, for the footer.

    def __init__(
        self,
        value: str = "",
        *,
        takes: str = "",  # The characters that pastes, and the first one typed, may have; "": all.
        placeholder: str = "",
        id: str | None = None,
        # The text has changed, by a program too, once mounted.
        changed: Callable[[], object] = lambda: None,
        submitted: Callable[[], object] = lambda: None,  # By enter, unless `next_field` is set.
        stepped: Callable[[int], object] = lambda _: None,  # By the arrows up (-1) and down (1).
        # With the reason why a paste was refused; None shows a notification.
        refused: Callable[[str], object] | None = None,
    ) -> None:
        super().__init__(value, placeholder=placeholder, id=id, compact=True, select_on_focus=False)
        self.cursor_blink = False  # Blinking causes traffic over SSH.
        self._takes = takes
        self._changed, self._submitted, self._stepped = changed, submitted, stepped
        self._refused = refused

    def is_text(self, character: str) -> bool:
        """Return True if a character that is typed now goes into the text, and is no command.

        An empty field takes the characters of `takes` only. Behind other text it takes every
        character: leaving one out would make a 15 of `1ox5`.
        """
        return self.value != "" or self._is_for(character)

    def is_typed(self, key: str) -> bool:
        """Return True if a key, such as `x` or `^x`, goes into the text now, and is no command."""
        return len(key) == 1 and self.is_text(key)

    def _is_for(self, character: str) -> bool:
        return not self._takes or character in self._takes

    def check_consume_key(self, key: str, character: str | None) -> bool:
        return super().check_consume_key(key, character) and self.is_text(character or "")

    def _forward_event(self, event: events.Event) -> None:
        """Insert a character or a paste at once, in place of the selection."""
        if isinstance(event, events.Key) and event.is_printable:
            self.replace(event.character or "", *self.selection)
        elif isinstance(event, events.Paste):
            self._paste(event.text.strip("\r\n"))
        else:
            super()._forward_event(event)

    def watch_value(self) -> None:
        if self.is_mounted:
            self._changed()

    async def action_submit(self) -> None:
        """Focus the next field of the form, or call `submitted` if this is the last one."""
        if self.next_field is not None:
            self.screen.set_focus(self.next_field)
        else:
            self._submitted()

    def action_step(self, step: int) -> None:
        """Call `stepped` for the arrow up (-1) or down (1)."""
        self._stepped(step)

    def fill(self, text: str) -> None:
        """Replace the text, and put the cursor at its end."""
        self.value = text
        self.cursor_position = len(text)

    def _paste(self, text: str) -> None:
        odd = next((char for char in text.strip() if not self._is_for(char)), "")
        why = f"it contains {odd!r}" if odd else ""
        if not odd and len(text.splitlines()) > 1:
            why = "it has several lines"
        if why:
            refuse = self._refused or partial(self.notify, markup=False)
            refuse(f"cannot paste this here: {why}")
        else:
            self.replace(text, *self.selection)


class SearchLine(Horizontal):
    """The line `/ brake   2 of 14` below a list, hidden unless its search is open or has a text."""

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


_LINE_PAD = 2  # Cells around the label, as `line-pad: 1` below has it on either side.


class Button(widgets.Button, inherit_css=False):
    """A button that calls a function or runs a command at once, where Textual's posts a message.

    It has none of the fifty-seven CSS rules of Textual's button, each of which every style lookup
    evaluates.
    """

    def __init__(
        self, label: str, does: str | Callable[[], object], *, id: str, disabled: bool = False
    ) -> None:
        super().__init__(label, id=id, disabled=disabled, compact=True)
        self._does = does

    def render_line(self, y: int) -> Strip:
        """Render the button, blank if it is too narrow for a label: there Textual fails."""
        if self.size.width <= _LINE_PAD:
            return Strip.blank(self.size.width, self.rich_style)
        return super().render_line(y)

    def press(self) -> Button:
        """Run the command or call the function at once; nothing if disabled or hidden."""
        super().press()
        if not self.disabled and self.display:
            if isinstance(self._does, str):
                cast("Any", self.app).action_command(self._does)
            else:
                self._does()
        return self
