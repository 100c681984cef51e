"""Panel 4: every parameter of every node."""

from __future__ import annotations

from collections.abc import Sequence

from textual.app import ComposeResult
from textual.content import Content

from archo_tui.robot.parameter_values import range_text
from archo_tui.robot.state import Parameter
from archo_tui.robot.text import harmless
from archo_tui.robot.values import text_of
from archo_tui.station import View
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import Columns, Rows, Text, column, pad
from archo_tui.widgets.search import Search

_NODE, _NAME, _VALUE = (16, 28), 21, (8, 20)  # columns: least and most, or least
_TYPE, _ALLOWED = 8, 11
_WAITING = "? waiting for the nodes to report their parameters"
_BETWEEN = 7  # blanks between the columns, and the mark of a change


class ParametersPanel(Panel):
    """A table of what the nodes reported; `*` marks what differs from the start."""

    number, title_text = 4, "Parameters"
    keys = (
        *(("edit", "edit"), ("filter", "filter"), ("undo", "undo")),
        *(("only_changed", "modified"), ("save", "save"), ("load", "load")),
    )

    def __init__(self) -> None:
        super().__init__()
        self._shown: tuple[Parameter, ...] = ()
        self._only_changed = False
        self._rows: Rows[Parameter] = Rows(
            lambda *drawn: parameter_lines(*drawn, both=self._only_changed),
            lambda p: (p.node, p.name),
            id="parameters",
            empty=_WAITING,
            action="app.command('edit')",
            columns=lambda *measured: parameter_columns(*measured, both=self._only_changed),
        )
        self.search = Search(self._rows)

        self._titles = Line(id="parameter-titles")

    def compose(self) -> ComposeResult:
        yield self._titles
        yield self._rows
        yield self.search

    def on_mount(self) -> None:
        self._fill()

    def take_focus(self) -> None:
        self.screen.set_focus(self._rows)

    @property
    def selected(self) -> Parameter | None:
        """The parameter under the cursor."""
        return self._rows.item

    def show(self, view: View) -> None:
        self.show_keys(view, "what differs from the start" if self._only_changed else "")
        if view.snapshot.parameters is not self._shown:
            self._shown = view.snapshot.parameters
            self._fill()

    def on_input_changed(self) -> None:
        self._fill()

    def toggle_changed(self) -> None:
        """Only what differs from the start, or all."""
        self._only_changed = not self._only_changed
        self._rows.empty = "nothing differs from the start" if self._only_changed else _WAITING
        self._rows.show(())  # what is left may be the same, and looks another way
        self._fill()

    def _fill(self) -> None:
        shown = self._shown
        if self._only_changed:
            shown = tuple(p for p in shown if p.is_changed)
        if self.search.value.strip():
            matches = self.search.matches
            shown = tuple(p for p in shown if matches(p.node, p.name, text_of(p.value)))
        self._rows.show(shown)
        self._show_titles()

    def on_resize(self) -> None:
        self.call_after_refresh(self._show_titles)

    def _show_titles(self) -> None:
        columns = self._rows.columns or parameter_columns((), self._rows.size.width)
        titles = _line("node", "name", "value", "", "type", "allowed", columns)
        self._titles.show(Content.styled(titles, "bold"))


def _value(parameter: Parameter, both: bool) -> str:
    """`0.5`, or with the start's `0.5 (was 0.8)`."""
    text = text_of(parameter.value)
    return f"{text} (was {text_of(parameter.initial)})" if both else text


def parameter_columns(
    parameters: Sequence[Parameter], width: int, *, both: bool = False
) -> Columns:
    """Of nodes, names and values, so that values, types and ranges are seen.

    A long name is cut in its middle, a value never: one that is longer moves its type.
    """
    value = column((_value(p, both)[: _VALUE[1]] for p in parameters), *_VALUE)
    room = width - value - _BETWEEN - _TYPE - _ALLOWED
    least, most = _NODE
    node = column({p.node.lstrip("/") for p in parameters}, least, min(most, room - _NAME))
    return node, column((p.name for p in parameters), _NAME, room - node), value


def parameter_lines(
    parameter: Parameter, _width: int, columns: Columns, *, both: bool = False
) -> list[Text]:
    """`motor_controller  max_speed   0.5 *  double    0.05 .. 2`."""
    line = _line(
        parameter.node.lstrip("/"),
        harmless(parameter.name),
        harmless(_value(parameter, both)),
        "*" if parameter.is_changed else "",
        parameter.type,
        range_text(parameter),
        columns,
    )
    return [(line, "bold" if parameter.is_changed else "")]


def _line(
    node: str, name: str, value: str, mark: str, kind: str, allowed: str, columns: Columns
) -> str:
    left = f"{pad(node, columns[0])}  {pad(name, columns[1])} {value:>{columns[2]}}"
    return f"{left} {mark:1}  {kind:<{_TYPE}} {allowed}".rstrip()
