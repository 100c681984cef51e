"""Edit one parameter: checked here before it is sent, and again by its node."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.markup import escape
from textual.widgets import Static

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.parameter_values import parse, range_text, typed_text
from archo_tui.robot.state import Parameter
from archo_tui.robot.text import HIDDEN, harmless, safe
from archo_tui.robot.values import same, text_of
from archo_tui.screens.dialog import Form
from archo_tui.station.station import View
from archo_tui.terminal.app import COMMANDS, start_worker


class EditParameter(Form):
    """Stays open, with the reason shown, until the node has taken the value or esc is pressed."""

    does = "Set"

    def __init__(
        self, parameter: Parameter, send: Callable[[Any], Awaitable[Outcome]], offered: Any
    ) -> None:
        """`offered` is the value that stands in the field."""
        self._text = safe(typed_text(offered))  # in full: what is sent must not be a part of it
        super().__init__("value", self._text, disabled=parameter.read_only)
        self._offered = offered
        self._parameter, self._send = parameter, send
        self._shown = parameter.value  # as it is now
        if parameter.read_only:
            self.standing = f"{parameter.name} is read-only: it can only be set at startup"

    def body(self) -> ComposeResult:
        parameter = self._parameter
        allowed = range_text(parameter)
        with Vertical(classes="dialog") as box:
            title = f"{parameter.node.lstrip('/')} {harmless(parameter.name)}"
            box.border_title = escape(title)
            box.border_subtitle = "enter set   esc cancel"
            yield Static(Content(parameter.description or "no description"))
            kind = f"{parameter.type}, {allowed}" if allowed else parameter.type
            yield Static(Content(f"type   {kind}"))
            yield Static(_now(parameter.value), id="now")
            yield Static(Content(f"start  {harmless(text_of(parameter.initial))}"))
            yield self.field
            yield from self.below_field()

    def follow(self, view: View) -> None:
        """Somebody else may change it meanwhile."""
        super().follow(view)
        wanted = self._parameter.node, self._parameter.name
        known = (p.value for p in view.snapshot.parameters if (p.node, p.name) == wanted)
        value = next(known, None)
        if not same(value, self._shown):
            self._shown = value
            self.write("#now", _now(value))

    def submit(self, typed: str) -> None:
        if self.is_asking:
            return
        try:
            value = self._value(typed)
        except ValueError as error:
            self.say(str(error))
            return
        self.is_asking = True
        self.say("asking the node ...")
        start_worker(self.app, partial(self._ask, value), COMMANDS)

    def _value(self, typed: str) -> Any:
        """What was typed; where the field could not show all there is, untouched it means that."""
        if self._text != typed_text(self._offered):
            if typed == self._text:
                return self._offered
            if HIDDEN in typed:
                raise ValueError(f"{HIDDEN} stands for what cannot be shown: type it anew")
        return parse(self._parameter, typed)

    async def _ask(self, value: Any) -> None:
        outcome = await self._send(value)
        self.is_asking = False
        self.end(outcome)


def _now(value: Any) -> Content:
    return Content(f"now    {harmless(text_of(value))}")
