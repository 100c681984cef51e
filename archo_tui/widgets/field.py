"""The input field that all panels and dialogs use; its keys act in the order of typing."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from textual import events
from textual.binding import Binding
from textual.geometry import Size
from textual.reactive import Reactive
from textual.widgets import Input

INTEGER = "-0123456789 "  # The characters of one or several whole numbers.
NUMBER = f"{INTEGER}.+"


class Field(Input, inherit_css=False):
    """An input of one line that handles keys and pastes at once, and reports changes by calls.

    Textual's own handles each key by messages: of keys typed fast, those behind an enter would
    arrive before anybody knew that something was entered.
    """

    DEFAULT_CSS = """
        Field { width: 100%; height: 1; scrollbar-size-horizontal: 0; pointer: text; }
        Field:focus { background-tint: $foreground 5%; }
        Field > .input--cursor {
            background: $input-cursor-background; color: $input-cursor-foreground;
            text-style: $input-cursor-text-style;
        }
        Field > .input--selection {
            background: $input-selection-background; color: $input-selection-foreground;
        }
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
