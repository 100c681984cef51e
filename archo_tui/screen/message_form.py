"""The dialog with a form for any goal or request."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial
from typing import Any

from textual import widgets  # `widgets.TextArea`, which is large, is imported with its first use.
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.markup import escape
from textual.widgets import Label, Static

from archo_tui.base.yaml_text.bounded_yaml import load
from archo_tui.base.yaml_text.core_schema import YamlFault
from archo_tui.base.yaml_text.dump import block
from archo_tui.robot.messages.typed import FieldError, default_text, parse_all, range_text
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import NOT_TAKEN_BACK, Outcome
from archo_tui.robot_file.model import FormField
from archo_tui.screen.dialog import Dialog
from archo_tui.screen.widgets.field import Button, Field

MAX_FIELDS = 12  # A message with more fields is edited as one YAML text.
Send = Callable[[Mapping[str, Any]], Awaitable[Outcome]]


class MessageForm(Dialog):
    """A dialog with a field for each primitive field of a message, which are sent together.

    A message with more than 12 of them is edited as one YAML text. The dialog stays open until the
    message was sent and accepted; a STOP closes it.
    """

    closes_at_stop = True

    BINDINGS = [("escape", "close", "Close"), ("ctrl+s", "send", "Send")]

    def __init__(
        self,
        title: str,
        message_fields: Sequence[TypedField],
        send: Send,  # Gets the values by dotted path; those of a YAML text are nested.
        # The last texts by path, of the YAML text under ""; changed by sending.
        typed: dict[str, str],
        # Labels, units and limits of the robot file, by path.
        form: Mapping[str, FormField] | None = None,
    ) -> None:
        super().__init__()
        self.title, self._message_fields, self._send = title, message_fields, send
        self._typed, self._form = typed, form or {}
        self._fields: list[Field] = []

    @property
    def _is_yaml(self) -> bool:
        return len(self._message_fields) > MAX_FIELDS

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog form") as box:
            box.border_title = escape(str(self.title))
            box.border_subtitle = self._keys
            if self._is_yaml:
                text = self._typed.get("", default_yaml(self._message_fields))
                yield widgets.TextArea(text, id="yaml")
            else:
                with VerticalScroll(classes="fields", can_focus=False):
                    yield from self._rows()
            yield Static("", classes="error")
            with Horizontal(classes="answers"):
                yield Button("Cancel", self.action_close, id="leave")
                yield Button("Send", self.action_send, id="send")

    @property
    def _keys(self) -> str:
        if self._is_yaml:
            return "^s send   esc cancel"
        if len(self._message_fields) > 1:
            return "enter next, then send   ↑ ↓ field   ^s send   esc cancel"
        return "enter send   esc cancel"

    def _rows(self) -> ComposeResult:
        labels = [self._label(message_field) for message_field in self._message_fields]
        width = max(map(len, labels), default=0) + 1
        for number, message_field in enumerate(self._message_fields):
            given = self._form_field(message_field)
            field = Field(
                self._typed.get(message_field.path, default_text(message_field, given)),
                id=f"field-{number}",
                changed=self.show_message,
                submitted=self.action_send,
                stepped=self._step,
            )
            if self._fields:
                self._fields[-1].next_field = field
            self._fields.append(field)
            with Horizontal(classes="message-field"):
                yield Label(f"{self._label(message_field):<{width}}", markup=False)
                yield field
                kind = ", ".join(filter(None, (message_field.type, range_text(given))))
                yield Label(f" {kind}", classes="type", markup=False)
        if not self._message_fields:
            yield Static(Content("It takes no values."))

    def _label(self, message_field: TypedField) -> str:
        given = self._form_field(message_field)
        label = given.label or message_field.path
        return f"{label} ({given.unit})" if given.unit else label

    def _form_field(self, message_field: TypedField) -> FormField:
        return self._form.get(message_field.path, FormField())

    def on_mount(self) -> None:
        first = "#yaml" if self._is_yaml else "#field-0" if self._message_fields else "#send"
        self.set_focus(self.query_one(first))

    def _step(self, step: int) -> None:
        """Focus the field before (-1) or behind (1) the one with the focus, in a circle."""
        number = next((n for n, field in enumerate(self._fields) if field is self.focused), 0)
        self.set_focus(self._fields[(number + step) % len(self._fields)])

    def on_text_area_changed(self, event: widgets.TextArea.Changed) -> None:
        if event.text_area.text != self._typed.get(""):
            # Otherwise the text was sent before this event was handled, and a message is shown.
            self.show_message()

    def action_send(self) -> None:
        """Check the values and send them, or show which one is not valid; once until the answer."""
        if self.is_asking:
            return
        values = self._values_of_yaml() if self._is_yaml else self._values()
        if values is not None:
            waiting = "asking the robot ...   esc stops waiting"
            self.ask(partial(self._send, values), self.finish, waiting)

    def action_close(self) -> None:
        """Close the dialog; while an answer is due, warn that what was sent is not taken back."""
        if self.is_asking and not self.is_dismissed:
            self.notify(f"{self.title}: {NOT_TAKEN_BACK}.", severity="warning", markup=False)
        super().action_close()

    def stop_waiting(self) -> None:
        self.action_close()

    def _values(self) -> dict[str, Any] | None:
        """Return and remember the values by path; None after showing which is not valid."""
        fields = {
            of.path: field for of, field in zip(self._message_fields, self._fields, strict=True)
        }
        texts = {path: field.value for path, field in fields.items()}
        self._typed.update(texts)
        try:
            return parse_all(self._message_fields, self._form, texts)
        except FieldError as error:
            self.show_message(str(error))
            self.set_focus(fields[error.path])
            return None

    def _values_of_yaml(self) -> dict[str, Any] | None:
        """Return and remember the YAML text's mapping; None after showing what is wrong."""
        text = self.query_one(widgets.TextArea).text
        self._typed[""] = text
        try:
            values = load(text)
        except YamlFault as fault:
            self.show_message(str(fault))
            return None
        if not isinstance(values, dict):
            self.show_message("expected lines like 'field: value'")
            return None
        return values


def default_yaml(message_fields: Sequence[TypedField]) -> str:
    """Return the default values of all fields as a YAML text, nested as the message is."""
    nested: dict[str, Any] = {}
    for field in message_fields:
        *parents, name = field.path.split(".")
        mapping = nested
        for parent in parents:
            mapping = mapping.setdefault(parent, {})
        mapping[name] = field.default
    return block(nested)
