"""The panel of parameters: every parameter of every node."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from textual.app import ComposeResult
from textual.content import Content

from archo_tui.base.safe_text import harmless
from archo_tui.robot.graph.parameter_values import range_text
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.state.graph import Parameter
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.widgets.field import Search
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.panel import NONE_RECORDED, ListPanel, ScreenState
from archo_tui.screen.widgets.rows import Rows
from archo_tui.text.columns import QUIET, Columns, Text, column, crop, fit_columns, in_columns

_NODE_WIDTH, _NAME_WIDTH, _VALUE_WIDTH = (16, 28), 21, (8, 20)  # Least, or least and most, cells.
_TITLES, _MARK = ("node", "name", "value  ", "type", "allowed"), " *"
_TYPE_WIDTH, _RANGE_WIDTH = (7, 9), (7, 11)
_STANDARD_NAMES = ("use_sim_time", "start_type_description_service")
_STANDARD_PREFIX = "qos_overrides."
_WAITING = "? waiting for the nodes to report their parameters"


class ParametersPanel(ListPanel[Parameter]):
    """The table of parameters; `*` marks those that differ from the start."""

    title_text, verbs, place = "Parameters", ("params", "get"), "right"
    keys = (
        *(("edit", "edit"), ("filter", "filter"), ("undo", "undo")),
        *(("only_changed", "changed"), ("save", "save"), ("load", "load")),
    )

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self._names = snapshot.file.shown
        self._parameters: tuple[Parameter, ...] = ()
        self._only_changed = False
        self._shows_all = False
        self._hidden_count = 0  # Parameters that the key hides or shows.
        # For everything, so that a filter moves no panel; with the descriptions, and without.
        self.lines = 0, 0
        self.rows: Rows[Parameter] = Rows(
            self._draw_parameter,
            lambda p: (p.node, p.name),
            id="parameters",
            empty=_WAITING,
            action="app.command('edit')",
            wraps=True,
            columns=self._measure,
        )
        self.search = Search(self.rows, self._refill)

        self._waiting = _WAITING  # The text of an empty table.
        self._titles = Line(id="parameter-titles")

    def compose(self) -> ComposeResult:
        yield self._titles
        yield self.rows
        yield self.search.line

    def on_mount(self) -> None:
        self._refill()

    def show(self, view: ScreenState) -> None:
        self.show_keys(view)
        waiting = NONE_RECORDED if view.replay else _WAITING
        if view.snapshot.parameters is not self._parameters or waiting != self._waiting:
            self._parameters, self._waiting = view.snapshot.parameters, waiting
            self._refill()
        self._show_hidden_hint(view)

    def _show_hidden_hint(self, view: ScreenState) -> None:
        """Show in the title how many other parameters a key shows or hides."""
        key, does = view.key("all_parameters"), "hides" if self._shows_all else "shows"
        text = f"{key} {does} {self._hidden_count} more".lstrip()
        note = f"   [not bold $quiet][@click=app.command('all_parameters')]{text}[/][/]"
        self.show_title(note if self._hidden_count else "")

    def _measure(self, parameters: Sequence[Parameter], width: int) -> Columns:
        rows, both = self.rows.size.height, self._only_changed
        return parameter_columns(parameters, width, rows, both=both)

    def _draw_parameter(self, parameter: Parameter, width: int, columns: Columns) -> list[Text]:
        return parameter_lines(parameter, width, columns, both=self._only_changed)

    def toggle_changed(self) -> None:
        """Show only the parameters that differ from the start, with both values, or all again."""
        self._only_changed = not self._only_changed
        self._refill()
        self.rows.redraw_all()

    def toggle_hidden(self) -> None:
        """Show or hide the unchanged parameters that an operator seldom changes.

        While a search or `toggle_changed` narrows the table, the choice shows only afterwards.
        """
        self._shows_all = not self._shows_all
        self._refill()

    def _refill(self) -> None:
        shown, typed = self._parameters, self.search.search_text
        empty = "nothing" if shown else self._waiting
        # Of a node that has none of the robot file's `shown`, all are shown.
        nodes = {p.node for p in shown if p.name in self._names}
        others = tuple(p for p in shown if p.is_changed or not _is_hidden(p, self._names, nodes))
        listed = shown if self._shows_all else others
        self.lines = 1 + len(listed) + sum(bool(p.description) for p in listed), 1 + len(listed)
        self._hidden_count = 0
        if not (self._only_changed or typed):
            self._hidden_count = len(shown) - len(others)
            shown = shown if self._shows_all else others
            empty = "nothing but what is hidden" if self._hidden_count else empty
        if self._only_changed and shown:
            shown = tuple(p for p in shown if p.is_changed)
            empty = "nothing differs from the start"
        total = len(shown)
        if typed and shown:
            matches = self.search.matches
            shown = tuple(p for p in shown if matches(p.node, p.name, text_of(p.value)))
            empty = f"nothing {'changed ' if self._only_changed else ''}contains {typed}"
        self.rows.show(shown, empty)
        changed = "what differs from the start" if self._only_changed else ""
        self.show_narrowed(changed, self.search.show_count(len(shown), total))
        self._show_titles()

    def on_resize(self) -> None:
        self.call_after_refresh(self._show_titles)

    def _show_titles(self) -> None:
        columns = self.rows.columns or parameter_columns((), self.rows.size.width, 0)
        titles = in_columns(_TITLES, columns[:-1], (2,))
        self._titles.show(Content.styled(titles, "bold"))


def _is_hidden(parameter: Parameter, shown: Sequence[str], nodes: Collection[str]) -> bool:
    """Return True for what ROS gives each node, and what these nodes have besides `shown`."""
    is_left_out = parameter.node in nodes and parameter.name not in shown
    is_standard = parameter.name in _STANDARD_NAMES or parameter.name.startswith(_STANDARD_PREFIX)
    return is_standard or is_left_out


def _value_text(parameter: Parameter, both: bool) -> str:
    """Return the value as text, `0.5`; if `both`, with the value at the start: `0.5 (was 0.8)`."""
    text = text_of(parameter.value)
    return f"{text} (was {text_of(parameter.initial)})" if both else text


def parameter_columns(
    parameters: Sequence[Parameter], width: int, rows: int, *, both: bool = False
) -> Columns:
    """Return the widths of nodes, names, values, types, ranges and descriptions; 0 hides them.

    If space is short, types are hidden first, then ranges, then nodes; a value is never cut.
    Descriptions have lines of their own if all of them have room.
    """
    nodes = column((p.node.lstrip("/") for p in parameters), *_NODE_WIDTH)
    names = column((p.name for p in parameters), _NAME_WIDTH, width)
    values = (_value_text(p, both)[: _VALUE_WIDTH[1]] for p in parameters)
    value = column(values, *_VALUE_WIDTH) + len(_MARK)
    kind = column((p.type for p in parameters), *_TYPE_WIDTH)
    ranges = [range_text(p) for p in parameters]
    bounds = (
        (_NODE_WIDTH[0], nodes),
        (_NAME_WIDTH, names),
        (value, value),
        (kind, kind),
        (column(ranges, *_RANGE_WIDTH), column(ranges, 0, width)),
    )
    columns = fit_columns(bounds, width, (2, 1, 0, 4, 3))
    lines = len(parameters) + sum(bool(p.description) for p in parameters)
    return *columns, max(width - columns[0] - 2, 0) if lines <= rows else 0


def parameter_lines(
    parameter: Parameter, _width: int, columns: Columns, *, both: bool = False
) -> list[Text]:
    """Return `motor_controller  max_speed   0.5 *  double  0.05 .. 2`, bold if changed."""
    node, *_, described = columns
    value = harmless(_value_text(parameter, both))
    texts = (
        parameter.node.lstrip("/"),
        harmless(parameter.name),
        f"{value}{_MARK if parameter.is_changed else ' ' * len(_MARK)}",
        parameter.type,
        crop(range_text(parameter), columns[4]),
    )
    lines = [(in_columns(texts, columns[:-1], (2,)), "bold" if parameter.is_changed else "")]
    if described and parameter.description:
        indent = " " * (node + 2 if node else 0)
        lines.append((f"{indent}{crop(parameter.description, described)}", QUIET))
    return lines
