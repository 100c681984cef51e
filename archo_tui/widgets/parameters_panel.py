"""Panel 4: every parameter of every node."""

from __future__ import annotations

from collections.abc import Sequence

from textual.app import ComposeResult
from textual.content import Content
from textual.widget import Widget

from archo_tui.robot.parameter_values import range_text
from archo_tui.robot.state import Parameter
from archo_tui.robot.text import harmless
from archo_tui.robot.values import same, text_of
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import Columns, Rows, Text, column, crop, pad
from archo_tui.widgets.search import Search
from archo_tui.widgets.shown import NONE_RECORDED, Shown

_NODE, _NAME, _VALUE = (16, 28), 21, (8, 20)  # columns: least and most, or least
_TYPE, _ALLOWED = (8, 9), (7, 11)
FLASH = 0.6  # s
_OF_EVERY_NODE = ("use_sim_time", "start_type_description_service")
_OF_EVERY_TOPIC = "qos_overrides."
_WAITING = "? waiting for the nodes to report their parameters"


class ParametersPanel(Panel):
    """A table of what the nodes reported; `*` marks what differs from the start."""

    number, title_text = 4, "Parameters"
    keys = (
        *(("edit", "edit"), ("filter", "filter"), ("undo", "undo")),
        *(("only_changed", "changed"), ("save", "save"), ("load", "load")),
    )

    def __init__(self) -> None:
        super().__init__()
        self._shown: tuple[Parameter, ...] = ()
        self._only_changed = False
        self._shows_ros_own = False
        self._ros_own = 0  # how many of those are hidden, or would be
        self.lines = 0  # that it needs for all, with the titles: a filter moves no other panel
        self._flashing: frozenset[tuple[str, str]] = frozenset()  # changed by somebody else
        self._rows: Rows[Parameter] = Rows(
            self._drawn,
            lambda p: (p.node, p.name),
            id="parameters",
            empty=_WAITING,
            action="app.command('edit')",
            columns=lambda *measured: parameter_columns(*measured, both=self._only_changed),
        )
        self.search = Search(self._rows, self._fill)

        self._waiting = _WAITING  # what is said while there are none
        self._titles = Line(id="parameter-titles")

    def compose(self) -> ComposeResult:
        yield self._titles
        yield self._rows
        yield self.search.line

    def on_mount(self) -> None:
        self._fill()

    @property
    def operated(self) -> Widget:
        return self._rows

    @property
    def shows_cursor(self) -> bool:
        """True when a person sees which parameter is selected."""
        return self._rows.shows_cursor

    @property
    def selected(self) -> Parameter | None:
        """The parameter under the cursor."""
        return self._rows.item

    def show(self, view: Shown) -> None:
        self.show_keys(view)
        if view.replay and self._waiting == _WAITING:
            self._waiting = NONE_RECORDED
            self._fill()
        if view.snapshot.parameters is not self._shown:
            before, self._shown = self._shown, view.snapshot.parameters
            if not view.changing:
                self._flash(before)
            self._fill()
        self._show_ros_own(view)

    def _show_ros_own(self, view: Shown) -> None:
        """Say in the title how many parameters of every ROS node its key shows, or hides."""
        key, does = view.key("ros_own"), "hides" if self._shows_ros_own else "shows"
        noun = "parameter" if self._ros_own == 1 else "parameters"
        text = f"{key} {does} {self._ros_own} standard {noun}".lstrip()
        note = f"   [not bold $quiet][@click=app.command('ros_own')]{text}[/][/]"
        self.show_title(note if self._ros_own else "")

    def _flash(self, before: Sequence[Parameter]) -> None:
        """What somebody else changed is seen by more than its new value, once."""
        values = {(p.node, p.name): p.value for p in before}
        names = (
            (p.node, p.name) for p in self._shown if not same(p.value, values.get((p.node, p.name)))
        )
        changed = frozenset(name for name in names if name in values)
        if changed and self.app.animation_level != "none":
            self._flashing = changed
            self.set_timer(FLASH, self._flashed)

    def _flashed(self) -> None:
        self._flashing = frozenset()
        self._rows.redraw()

    def _drawn(self, parameter: Parameter, width: int, columns: Columns) -> list[Text]:
        lines = parameter_lines(parameter, width, columns, both=self._only_changed)
        if (parameter.node, parameter.name) not in self._flashing:
            return lines
        return [(text, f"{style} reverse".lstrip()) for text, style in lines]

    def toggle_changed(self) -> None:
        """Only what differs from the start, or all."""
        self._only_changed = not self._only_changed
        self._rows.show(())  # what is left may be the same, and looks another way
        self._fill()

    def toggle_ros_own(self) -> None:
        """Hide the parameters that every node of ROS has, or show them."""
        self._shows_ros_own = not self._shows_ros_own
        self._fill()

    def _fill(self) -> None:
        shown, typed = self._shown, self.search.wanted
        empty = "nothing" if shown else self._waiting
        others = tuple(p for p in shown if p.is_changed or not _is_ros_own(p))
        self.lines = 1 + len(shown if self._shows_ros_own else others)
        self._ros_own = 0
        if not (self._only_changed or typed):
            self._ros_own = len(shown) - len(others)
            shown = shown if self._shows_ros_own else others
            empty = "nothing but ROS's own" if self._ros_own else empty
        if self._only_changed and shown:
            shown = tuple(p for p in shown if p.is_changed)
            empty = "nothing differs from the start"
        total = len(shown)
        if typed and shown:
            matches = self.search.matches
            shown = tuple(p for p in shown if matches(p.node, p.name, text_of(p.value)))
            empty = f"nothing {'changed ' if self._only_changed else ''}contains {typed}"
        self._rows.empty = empty
        self._rows.show(shown)
        changed = "what differs from the start" if self._only_changed else ""
        self.show_narrowed(changed, self.search.narrowed(len(shown), total))
        self._show_titles()

    def on_resize(self) -> None:
        self.call_after_refresh(self._show_titles)

    def _show_titles(self) -> None:
        columns = self._rows.columns or parameter_columns((), self._rows.size.width)
        titles = _line("node", "name", "value", "", "type", "allowed", columns)
        self._titles.show(Content.styled(titles, "bold"))


def _is_ros_own(parameter: Parameter) -> bool:
    """True for what every node of ROS has, whatever it is for."""
    return parameter.name in _OF_EVERY_NODE or parameter.name.startswith(_OF_EVERY_TOPIC)


def _value(parameter: Parameter, both: bool) -> str:
    """`0.5`, or with the start's `0.5 (was 0.8)`."""
    text = text_of(parameter.value)
    return f"{text} (was {text_of(parameter.initial)})" if both else text


def parameter_columns(
    parameters: Sequence[Parameter], width: int, *, both: bool = False
) -> Columns:
    """Of nodes, names, values, types and ranges; 0 for one that has no room.

    Name and value come first, then the node, the range, the type. A long name is cut in its middle,
    a long range at its end, a value never: one that is longer moves its type.
    """
    value = column((_value(p, both)[: _VALUE[1]] for p in parameters), *_VALUE)
    room = width - value - _NAME - 3  # blanks, and the mark of a change
    least, most = _NODE
    node = least if room >= least + 2 else 0
    room -= node + 2 if node else 0
    ranges = [range_text(p) for p in parameters]
    allowed = column(ranges, *_ALLOWED)
    allowed = allowed if node and room >= allowed + 2 else 0
    room -= allowed + 2 if allowed else 0
    kind = column((p.type for p in parameters), *_TYPE)
    kind = kind if allowed and room >= kind + 1 else 0
    room -= kind + 1 if kind else 0
    if allowed:
        more = column(ranges, allowed, allowed + max(room, 0)) - allowed
        allowed, room = allowed + more, room - more
    if node:
        nodes = {p.node.lstrip("/") for p in parameters}
        node = column(nodes, least, min(most, least + max(room, 0)))
        room -= node - least
    name = column((p.name for p in parameters), _NAME, _NAME + max(room, 0))
    return node, name, value, kind, allowed


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
    nodes, names, values, kinds, ranges = columns
    left = f"{pad(node, nodes)}  " if nodes else ""
    right = f"  {kind:<{kinds}}" if kinds else ""
    allowed = crop(allowed, ranges)
    right += f" {allowed}" if kinds else f"  {allowed}" if ranges else ""
    return f"{left}{pad(name, names)} {value:>{values}} {mark:1}{right}".rstrip()
