"""The dialog that edits a parameter; the value is checked here, then by its node."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.markup import escape
from textual.widgets import Static

from archo_tui.robot.graph.parameter_values import parse, range_text
from archo_tui.robot.messages.typed import typed_text
from archo_tui.robot.messages.values import same, text_of
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.graph import Parameter
from archo_tui.safe_text import HIDDEN, harmless, safe
from archo_tui.screens.dialog import Form
from archo_tui.terminal.app import COMMANDS, start_worker
from archo_tui.widgets.screen_state import ScreenState


class EditParameter(Form):
    """A dialog with a field for a parameter's value, which stays open until the node accepts it."""

    submit_label = "Set"

    def __init__(
        self, parameter: Parameter, send: Callable[[Any], Awaitable[Outcome]], offered: Any
    ) -> None:
        # In full, since all of the field is sent.
        self._text = safe(typed_text(offered))
        super().__init__("value", self._text, disabled=parameter.read_only)
        self._offered = offered
        self._parameter, self._send = parameter, send
        self._shown = parameter.value  # The present value.
        allowed = range_text(parameter)
        kind = f"{parameter.type}, {allowed}" if allowed else parameter.type
        self.hint = Content.styled(kind, "not bold $quiet")
        if parameter.read_only:
            self.hint = Content(f"{parameter.name} is read-only: it can only be set at startup")

    def body(self) -> ComposeResult:
        parameter = self._parameter
        with Vertical(classes="dialog") as box:
            title = f"{parameter.node.lstrip('/')} {harmless(parameter.name)}"
            box.border_title = escape(title)
            box.border_subtitle = "enter set   esc cancel"
            yield Static(Content(parameter.description or "no description"))
            yield Static(_value_line(parameter.value), id="now")
            yield Static(Content(f"start  {harmless(text_of(parameter.initial))}"))
            yield self.field
            yield from self.below_field()

    def show_view(self, view: ScreenState) -> None:
        """Show the present value, which others may change meanwhile; the field keeps its text."""
        super().show_view(view)
        key = self._parameter.node, self._parameter.name
        values = (p.value for p in view.snapshot.parameters if (p.node, p.name) == key)
        value = next(values, None)
        if not same(value, self._shown):
            self._shown = value
            self.set_text("#now", _value_line(value))

    def submit(self, typed: str) -> None:
        if self.is_asking:
            return
        try:
            value = self._parse(typed)
        except ValueError as error:
            self.show_message(str(error))
            return
        self.is_asking = True
        self.show_message("asking the node ...")
        start_worker(self.app, partial(self._set, value), COMMANDS)

    def _parse(self, typed: str) -> Any:
        """Return the value that a text means; ValueError if it is none of the parameter's.

        The untouched text of an offered value with hidden characters means that value; an edited
        text must be free of the marks that stand for them.
        """
        if self._text != typed_text(self._offered):
            if typed == self._text:
                return self._offered
            if HIDDEN in typed:
                raise ValueError(f"{HIDDEN} stands for what cannot be shown: type it again")
        return parse(self._parameter, typed)

    async def _set(self, value: Any) -> None:
        outcome = await self._send(value)
        self.is_asking = False
        self.finish(outcome)


def _value_line(value: Any) -> Content:
    return Content(f"now    {harmless(text_of(value))}")
