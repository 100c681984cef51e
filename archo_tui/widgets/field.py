"""The one kind of field: what is typed acts in the order in which it was typed."""

from __future__ import annotations

from textual import events
from textual.geometry import Size
from textual.message import Message
from textual.reactive import Reactive
from textual.widgets import Input

INTEGER = "-0123456789 "  # what a whole number, or several, can contain
NUMBER = f"{INTEGER}.+"


class Field(Input, inherit_css=False):
    """An input of one line whose editing keys act at once.

    Textual's own inserts characters itself, but leaves backspace, enter and the like to bindings
    that are looked up when the key has bubbled up to the app: typed fast, `1 2 backspace 3 enter`
    submits 12.
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

    class Refused(Message):
        """Something was pasted that this field cannot contain."""

        def __init__(self, reason: str) -> None:
            super().__init__()
            self.reason = reason

    class Recall(Message):
        """The arrows ask for what was typed before (-1) or after that (1)."""

        def __init__(self, step: int) -> None:
            super().__init__()
            self.step = step

    class Chosen(events.Paste):
        """A word that was chosen elsewhere; it takes its turn among the keys."""

    # as every widget's, but for laying out the whole screen at each letter: no field grows
    virtual_size = Reactive(Size(0, 0))
    next_field: Field | None = None  # where enter leads, in a form of several

    def __init__(
        self, value: str = "", *, takes: str = "", placeholder: str = "", id: str | None = None
    ) -> None:
        """`takes` are the characters that it is for, empty for all."""
        super().__init__(value, placeholder=placeholder, id=id, compact=True)
        self.cursor_blink = False  # a blinking cursor is traffic over SSH
        self._takes = takes
        self._coming = 0  # what is on its way to it: keys, pastes, the answer to an enter
        self._will_hold = False  # text, after all that
        self._is_odd = False  # a character among it that this field is not for

    def is_text(self, character: str) -> bool:
        """True when that character, typed now, is text here, and not a command.

        Behind other text every character is: what is dropped or done makes `1ox5` a 15.
        """
        return self._holds_text or self._is_for(character)

    @property
    def _holds_text(self) -> bool:
        """After all that is on its way, as far as that can be told."""
        return self._will_hold if self._coming else self.value != ""

    def _is_for(self, character: str) -> bool:
        return not self._takes or character in self._takes

    def check_consume_key(self, key: str, character: str | None) -> bool:
        return super().check_consume_key(key, character) and self.is_text(character or "")

    def post_message(self, message: Message) -> bool:
        is_queued = super().post_message(message)
        if is_queued and isinstance(message, (events.Key, events.Paste)):
            if not self._coming:
                self._is_odd = not all(map(self._is_for, self.value))
            self._will_hold = self._holds_text
            if isinstance(message, events.Paste) or message.is_printable:
                self._will_hold = True
                if isinstance(message, events.Key):
                    typed = message.character or ""
                else:
                    typed = message.text.strip()
                self._is_odd = self._is_odd or not all(map(self._is_for, typed))
            elif message.key == "enter":  # which is refused, and clears nothing, if it is odd
                self._will_hold = self._is_odd
            self._coming += 1
        return is_queued

    async def on_event(self, event: events.Event) -> None:
        try:
            await super().on_event(event)
        finally:
            if isinstance(event, (events.Key, events.Paste)):
                self._coming -= 1

    async def action_submit(self) -> None:
        if self._takes:
            self._coming += 1  # until `answered`
        await super().action_submit()

    def answered(self) -> None:
        """Whoever heard that it was submitted has cleared it, or has not."""
        if self._takes:
            self._coming -= 1

    async def _on_key(self, event: events.Key) -> None:
        if event.key in ("up", "down"):
            event.stop()
            event.prevent_default()
            self.post_message(self.Recall(-1 if event.key == "up" else 1))
            return
        if event.key in ("pageup", "pagedown"):
            return  # of the dialog's list: Textual has them for any widget that scrolls
        for binding in self._bindings.key_to_bindings.get(event.key, ()):
            event.stop()
            event.prevent_default()
            await self.run_action(binding.action)
            return

    def choose(self, word: str) -> None:
        """Write a word behind all that is typed, with blanks around it."""
        self.post_message(self.Chosen(word))

    def _on_field_chosen(self, event: Chosen) -> None:
        event.stop()
        apart = " " if self.value[-1:].strip() else ""
        self.value = f"{self.value}{apart}{event.text} "
        self.cursor_position = len(self.value)

    def _on_paste(self, event: events.Paste) -> None:
        odd = next((char for char in event.text.strip() if not self._is_for(char)), "")
        why = f"it contains {odd!r}" if odd else ""
        if not odd and len(event.text.strip().splitlines()) > 1:  # Textual takes the first one
            why = "it has several lines"
        if why:
            event.stop()
            event.prevent_default()
            self.post_message(self.Refused(f"cannot paste this here: {why}"))
