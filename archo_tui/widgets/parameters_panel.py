"""Panel 4: every parameter of every node."""

from __future__ import annotations

from typing import Any

from textual.app import ComposeResult
from textual.content import Content
from textual.message import Message
from textual.widgets import DataTable

from archo_tui.robot.events import harmless
from archo_tui.robot.state import Parameter
from archo_tui.robot.values import range_text, text_of
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.view import View

_COLUMNS = (("node", 16), ("name", 21), ("value", 8), ("type", 8), ("allowed", 11))
_LONGEST = 60  # characters of a value in the table


class ParametersPanel(Panel):
    """A table whose cells change only when a node reports another value."""

    number, title_text, keys = 4, "Parameters", "enter edit"

    class Edit(Message):
        """The operator wants to edit this parameter."""

        def __init__(self, parameter: Parameter) -> None:
            super().__init__()
            self.parameter = parameter

    def __init__(self) -> None:
        super().__init__()
        self._shown: tuple[Parameter, ...] = ()

    def compose(self) -> ComposeResult:
        table: DataTable[Any] = DataTable(cursor_type="row", id="parameters")
        for name, width in _COLUMNS:
            label = name.rjust(width) if name == "value" else name
            table.add_column(label, key=name, width=width)
        yield table

    def take_focus(self) -> None:
        self.screen.set_focus(self.query_one(DataTable))

    def show(self, view: View) -> None:
        parameters = view.snapshot.parameters
        if parameters == self._shown:
            return
        old, self._shown = self._shown, parameters
        table = self.query_one(DataTable)
        if [_key(p) for p in old] == [_key(p) for p in parameters]:
            for before, after in zip(old, parameters, strict=True):
                if before != after:
                    table.update_cell(_key(after), "value", _value(after))
            return
        row = table.cursor_row
        table.clear()
        for parameter in parameters:
            table.add_row(*_row(parameter), key=_key(parameter))
        table.move_cursor(row=min(row, len(parameters) - 1))

    def on_data_table_row_selected(self, event: DataTable.RowSelected) -> None:
        event.stop()
        found = [p for p in self._shown if _key(p) == event.row_key.value]
        if found:
            self.post_message(self.Edit(found[0]))


def _key(parameter: Parameter) -> str:
    return f"{parameter.node} {parameter.name}"


def _value(parameter: Parameter) -> Content:
    text = harmless(text_of(parameter.value))
    text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
    mark = " *" if parameter.is_changed else ""
    return Content.styled(f"{text}{mark}".rjust(_COLUMNS[2][1]), "bold" if mark else "")


def _row(parameter: Parameter) -> list[Content]:
    node = Content(parameter.node.lstrip("/"))
    return [
        node,
        Content(harmless(parameter.name)),
        _value(parameter),
        Content(parameter.type),
        Content(range_text(parameter)),
    ]
