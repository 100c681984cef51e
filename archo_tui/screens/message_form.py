"""A form for any goal or request: a field a leaf, or one YAML text where they are many."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from functools import partial
from typing import Any

from textual import widgets  # of these TextArea is loaded with its first use: it is large
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.markup import escape
from textual.widgets import Label, Static

from archo_tui.robot.forms import default_text, parse
from archo_tui.robot.outcome import NOT_TAKEN_BACK, Outcome
from archo_tui.robot.state import Leaf
from archo_tui.robot_file.model import FormField
from archo_tui.screens.dialog import Dialog
from archo_tui.terminal.app import COMMANDS, start_worker
from archo_tui.widgets.button import Button
from archo_tui.widgets.field import Field
from archo_tui.yaml_text.bounded_yaml import load
from archo_tui.yaml_text.core_schema import YamlFault
from archo_tui.yaml_text.dump import block

MOST_FIELDS = 12  # beyond that it is one YAML text
Send = Callable[[Mapping[str, Any]], Awaitable[Outcome]]


class MessageForm(Dialog[None]):
    """Stays open, with what is wrong, until it was sent and accepted, or esc is pressed."""

    closes_at_stop = True

    BINDINGS = [("escape", "close", "Close"), ("ctrl+s", "send", "Send")]

    def __init__(
        self,
        title: str,
        leaves: Sequence[Leaf],
        send: Send,
        typed: dict[str, str],
        form: Mapping[str, FormField] | None = None,
    ) -> None:
        """`typed` is what was typed the last time, by path; what is sent is kept there."""
        super().__init__()
        self.title, self._leaves, self._send = title, leaves, send
        self._typed, self._form = typed, form or {}
        self._fields: list[Field] = []

    @property
    def _is_yaml(self) -> bool:
        return len(self._leaves) > MOST_FIELDS

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog form") as box:
            box.border_title = escape(str(self.title))
            box.border_subtitle = self._keys
            if self._is_yaml:
                yield widgets.TextArea(self._typed.get("", _yaml(self._leaves)), id="yaml")
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
        if len(self._leaves) > 1:
            return "enter next, then send   ↑ ↓ field   ^s send   esc cancel"
        return "enter send   esc cancel"

    def _rows(self) -> ComposeResult:
        width = max((len(self._label(leaf)) for leaf in self._leaves), default=0) + 1
        for number, leaf in enumerate(self._leaves):
            field = Field(
                self._typed.get(leaf.path, default_text(leaf)),
                id=f"field-{number}",
                changed=self.say,
                submitted=self.action_send,
                stepped=self._step,
            )
            if self._fields:
                self._fields[-1].next_field = field
            self._fields.append(field)
            with Horizontal(classes="leaf"):
                yield Label(f"{self._label(leaf):<{width}}", markup=False)
                yield field
                yield Label(f" {leaf.type}", classes="type", markup=False)
        if not self._leaves:
            yield Static(Content("It takes no values."))

    def _label(self, leaf: Leaf) -> str:
        given = self._form.get(leaf.path, FormField())
        label = given.label or leaf.path
        return f"{label} ({given.unit})" if given.unit else label

    def on_mount(self) -> None:
        first = "#yaml" if self._is_yaml else "#field-0" if self._leaves else "#send"
        self.set_focus(self.query_one(first))

    def _step(self, step: int) -> None:
        """Lead from field to field by the arrows."""
        number = next((n for n, field in enumerate(self._fields) if field is self.focused), 0)
        self.set_focus(self._fields[(number + step) % len(self._fields)])

    def on_text_area_changed(self, event: widgets.TextArea.Changed) -> None:
        if event.text_area.text != self._typed.get(""):  # else it was sent before this message came
            self.say()

    def action_send(self) -> None:
        """Send it from any field."""
        if self.is_asking:
            return
        values = self._values_of_yaml() if self._is_yaml else self._values()
        if values is not None:
            self.is_asking = True
            self.say("asking the robot ...   esc stops waiting")
            start_worker(self.app, partial(self._ask, values), COMMANDS)

    def action_close(self) -> None:
        """Close; what was sent is not taken back by that, which is said."""
        if self.is_asking and not self.has_left:
            self.notify(f"{self.title}: {NOT_TAKEN_BACK}.", severity="warning", markup=False)
        super().action_close()

    def stop_waiting(self) -> None:
        self.action_close()

    def _values(self) -> dict[str, Any] | None:
        values = {}
        for number, leaf in enumerate(self._leaves):
            text = self._typed[leaf.path] = self._fields[number].value
            try:
                values[leaf.path] = parse(leaf, self._form.get(leaf.path, FormField()), text)
            except ValueError as error:
                self.say(str(error))
                self.set_focus(self._fields[number])
                return None
        return values

    def _values_of_yaml(self) -> dict[str, Any] | None:
        text = self.query_one(widgets.TextArea).text
        self._typed[""] = text
        try:
            values = load(text)
        except YamlFault as fault:
            self.say(str(fault))
            return None
        if not isinstance(values, dict):
            self.say("expected lines like 'field: value'")
            return None
        return values

    async def _ask(self, values: Mapping[str, Any]) -> None:
        outcome = await self._send(values)
        self.is_asking = False
        self.end(outcome)


def _yaml(leaves: Sequence[Leaf]) -> str:
    """The defaults as a YAML text, nested as the message is."""
    nested: dict[str, Any] = {}
    for leaf in leaves:
        *before, last = leaf.path.split(".")
        place = nested
        for name in before:
            place = place.setdefault(name, {})
        place[last] = leaf.default
    return block(nested)
