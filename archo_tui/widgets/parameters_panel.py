"""Panel 4: every parameter of every node."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.content import Content

from archo_tui.robot.events import harmless
from archo_tui.robot.parameter_values import range_text, text_of
from archo_tui.robot.state import Parameter
from archo_tui.station import View
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import Rows, Text, pad
from archo_tui.widgets.search import Search

_NODE, _NAME, _VALUE, _TYPE = 16, 21, 8, 8  # columns
_LONGEST = 60  # characters of a value in the table


class ParametersPanel(Panel):
    """A table of what the nodes reported; `*` marks what differs from the start."""

    number, title_text = 4, "Parameters"
    keys = (("edit", "edit"), ("filter", "filter"), ("undo", "undo"), ("save", "save"))

    def __init__(self) -> None:
        super().__init__()
        self._shown: tuple[Parameter, ...] = ()
        self._rows: Rows[Parameter] = Rows(
            parameter_lines,
            lambda p: (p.node, p.name),
            id="parameters",
            empty="? waiting for the nodes to report their parameters",
            action="app.command('edit')",
        )
        self.search = Search(self._rows)

    def compose(self) -> ComposeResult:
        yield Line(id="parameter-titles")
        yield self._rows
        yield self.search

    def on_mount(self) -> None:
        titles = _line("node", "name", "value", "", "type", "allowed")
        self.query_one("#parameter-titles", Line).show(Content.styled(titles, "bold"))

    def take_focus(self) -> None:
        self.screen.set_focus(self._rows)

    @property
    def selected(self) -> Parameter | None:
        """The parameter under the cursor."""
        return self._rows.item

    def show(self, view: View) -> None:
        self.show_keys(view)
        if view.snapshot.parameters is not self._shown:
            self._shown = view.snapshot.parameters
            self._fill()

    def on_input_changed(self) -> None:
        self._fill()

    def _fill(self) -> None:
        if not self.search.value.strip():
            self._rows.show(self._shown)
            return
        matches = self.search.matches
        self._rows.show(tuple(p for p in self._shown if matches(p.node, p.name, text_of(p.value))))


def parameter_lines(parameter: Parameter, _width: int) -> list[Text]:
    """`motor_controller  max_speed   0.5 *  double    0.05 .. 2`."""
    text = harmless(text_of(parameter.value))
    text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
    line = _line(
        parameter.node.lstrip("/"),
        harmless(parameter.name),
        text,
        "*" if parameter.is_changed else "",
        parameter.type,
        range_text(parameter),
    )
    return [(line, "bold" if parameter.is_changed else "")]


def _line(node: str, name: str, value: str, mark: str, kind: str, allowed: str) -> str:
    left = f"{pad(node, _NODE)}  {pad(name, _NAME)} {value:>{_VALUE}}"
    return f"{left} {mark:1}  {kind:<{_TYPE}} {allowed}".rstrip()
