"""The commands of Parameters, and the dialog that edits one."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any

from textual.app import ComposeResult
from textual.content import Content
from textual.widgets import Static

from archo_tui.base.errors import ArchoError
from archo_tui.base.safe_text import HIDDEN, harmless, safe
from archo_tui.robot.graph.parameter_values import parse, range_text
from archo_tui.robot.messages.typed import typed_text
from archo_tui.robot.messages.values import same, text_of
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.graph import Parameter
from archo_tui.screen.commands.base import IN_PANEL, Command, Desk, VerbCommand, Work
from archo_tui.screen.dialog import AskPath, Form
from archo_tui.screen.widgets.panel import ScreenState
from archo_tui.screen.widgets.parameters_panel import ParametersPanel
from archo_tui.verbs.parameters import NOBODY

_DEFAULT_FILE = "archo_params.yaml"


class _InParameters(Command):
    where, panel = IN_PANEL, ParametersPanel

    def disabled_reason(self, desk: Desk) -> str:
        return "" if desk.view.snapshot.parameters else NOBODY


class _SetCommand(_InParameters):
    verbs = ("set",)

    def disabled_reason(self, desk: Desk) -> str:
        return desk.verbs["set"].refusal(desk.station) or super().disabled_reason(desk)

    async def set(self, desk: Desk, parameter: Parameter, value: Any) -> Outcome:
        """Set a parameter, and return the answer of its node."""
        given = {"node": parameter.node, "name": parameter.name, "value": value}
        return await desk.verbs["set"].run(desk.station, given)


class Edit(_SetCommand):
    id, key = "edit", "enter"
    help = "Edit the selected parameter"
    restores = False  # True: the value at the start is in the field of the dialog at first.

    def run(self, desk: Desk) -> None:
        desk.main.parameters.take_focus()  # Shows the cursor, so that the parameter is visible.
        parameter = desk.main.parameters.selected
        if parameter is not None:
            self.open(desk, parameter)

    def open(self, desk: Desk, parameter: Parameter) -> None:
        """Open the dialog in which a parameter is edited."""
        send = partial(self.set, desk, parameter)
        offered = parameter.initial if self.restores else parameter.value
        desk.open(EditParameter(parameter, send, offered))


class EditWithInitial(Edit):
    id, key = "restore", "backspace"
    help = "Restore the selected parameter: opens its dialog with the value at the start"
    restores = True


class SwitchBoolean(_SetCommand):
    id, key = "switch", "space"
    help = "Toggle the selected boolean parameter"
    waits_for_answer = True

    def disabled_reason(self, desk: Desk) -> str:
        if not desk.main.parameters.rows.shows_cursor:
            return "no parameter is selected: choose one with ↑ ↓ first"
        selected = desk.main.parameters.selected
        if selected is None or not isinstance(selected.value, bool):
            return "the selected parameter is not a boolean"
        read_only = f"{selected.name} is read-only" if selected.read_only else ""
        return super().disabled_reason(desk) or read_only

    def run(self, desk: Desk) -> Work | None:
        selected = desk.main.parameters.selected
        assert selected is not None

        async def switch() -> None:
            desk.report_failure(await self.set(desk, selected, not selected.value))

        return switch()


class ToggleOnlyChanged(_InParameters):
    in_replay = True
    id, key = "only_changed", "d"
    help = "Show only changed parameters: those that differ from the start; or all again"

    def run(self, desk: Desk) -> None:
        desk.main.parameters.toggle_changed()


class ToggleHidden(_InParameters):
    in_replay = True
    id, key = "all_parameters", "full_stop"
    help = "Show or hide the other parameters: those that an operator seldom changes"
    gives_way = True

    def run(self, desk: Desk) -> None:
        desk.main.parameters.toggle_hidden()
        desk.update_screen()


class FilterParameters(_InParameters):
    in_replay = True
    id, key = "filter", "slash"
    help = "Filter the parameters: shows those whose node, name or value contains your text"

    def run(self, desk: Desk) -> None:
        desk.main.parameters.search.open()


class SaveKey(VerbCommand):
    in_replay = True
    where, panel = IN_PANEL, ParametersPanel
    key = "ctrl+s"

    def run(self, desk: Desk) -> None:
        async def save(path: Path) -> str:
            station = desk.station
            values = await self.verb.prepare(station, {"file": str(path)})
            outcome = await self.verb.run(station, values)
            if outcome.ok:
                desk.show_message(f"Saved to {path}.")
            return "" if outcome.ok else outcome.text

        title = "Save parameters"
        desk.open(AskPath(title, "ROS parameter file", _DEFAULT_FILE, save, writes=True))


class LoadKey(VerbCommand):
    where, panel = IN_PANEL, ParametersPanel
    key = "ctrl+o"

    def run(self, desk: Desk) -> None:
        async def load(path: Path) -> str:
            try:
                values = await self.verb.prepare(desk.station, {"file": str(path)})
            except ArchoError as error:
                return str(error)
            if dialog.is_dismissed:  # The operator has closed it meanwhile.
                return ""
            dialog.dismiss()  # Before the question, which would be beneath it.
            desk.run_verb(self.verb, values)  # It asks a question: there is nothing to wait for.
            return ""

        dialog = AskPath("Load parameters", "ROS parameter file", _DEFAULT_FILE, load)
        desk.open(dialog)


class EditParameter(Form):
    """A dialog with a field for a parameter's value, which stays open until the node accepts it."""

    submit_label = "Set"

    def __init__(
        self, parameter: Parameter, send: Callable[[Any], Awaitable[Outcome]], offered: Any
    ) -> None:
        # In full, since all of the field is sent.
        self._text = safe(typed_text(offered))
        title = f"{parameter.node.lstrip('/')} {harmless(parameter.name)}"
        super().__init__("value", self._text, title=title, disabled=parameter.read_only)
        self._offered = offered
        self._parameter, self._send = parameter, send
        self._shown = parameter.value  # The present value.
        allowed = range_text(parameter)
        kind = f"{parameter.type}, {allowed}" if allowed else parameter.type
        self.hint = Content.styled(kind, "not bold $quiet")
        if parameter.read_only:
            self.hint = Content(f"{parameter.name} is read-only: it can only be set at startup")

    def above_field(self) -> ComposeResult:
        parameter = self._parameter
        yield Static(Content(parameter.description or "no description"))
        yield Static(_value_line(parameter.value), id="now")
        yield Static(Content(f"start  {harmless(text_of(parameter.initial))}"))

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
        try:
            value = self._parse(typed)
        except ValueError as error:
            self.show_message(str(error))
        else:
            self.ask(partial(self._send, value), self.finish, "asking the node ...")

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


def _value_line(value: Any) -> Content:
    return Content(f"now    {harmless(text_of(value))}")
