"""The panel of the graph: topics, services and actions, with the nodes that have them."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from textual.app import ComposeResult
from textual.widget import Widget

from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.text.graph import ResourceRow, resource_rows
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text, column, crop, pad
from archo_tui.widgets.screen_state import NONE_RECORDED, ScreenState

_KIND_WIDTH = 8  # Cells of `service` and a blank.
_GAP = 2
_STRONG = "bold"


def resource_columns(rows: Sequence[ResourceRow], width: int) -> Columns:
    """Return the widths of names, types, nodes and rates; of rates only if not all fit on a row."""
    names = column((row.resource.name for row in rows), 0, width)
    types = column((row.types for row in rows), 0, width)
    nodes = column((row.who for row in rows), 0, width)
    rate_width = column((row.rate for row in rows), 0, width)
    room = width - _KIND_WIDTH - names - types - rate_width - 3 * _GAP
    return (names, types, room, rate_width) if nodes <= room else (rate_width,)


def resource_lines(row: ResourceRow, width: int, columns: Columns) -> list[Text]:
    """Return a row as `topic   /scan  sensor_msgs/msg/LaserScan  lidar  10.0 Hz`.

    With one column only it takes two lines; mismatches of type or QoS stand below.
    """
    wrong = [
        (f"  {line}", _STRONG)
        for mismatch in row.resource.mismatches
        for line in textwrap.wrap(mismatch, max(width - 2, 10))
    ]
    return [*_resource_lines(row, width, columns), *wrong]


def _resource_lines(row: ResourceRow, width: int, columns: Columns) -> list[Text]:
    kind, name = f"{row.resource.kind:<{_KIND_WIDTH}}", row.resource.name
    style = "" if row.resource.nodes else QUIET
    if len(columns) > 1:
        names, types, nodes, rate_width = columns
        rate = f"{row.rate:>{rate_width}}"
        return [(f"{kind}{name:<{names}}  {row.types:<{types}}  {row.who:<{nodes}}  {rate}", style)]
    room = width - _KIND_WIDTH - (columns[0] + _GAP if columns[0] else 0)
    rate = f"  {row.rate:>{columns[0]}}" if columns[0] else ""
    below = f"  {row.short_types}  {row.who}"
    return [(f"{kind}{pad(name, max(room, 1))}{rate}", style), (crop(below, width), QUIET)]


class GraphPanel(Panel):
    """The list of topics, services and actions."""

    title_text, verbs, place, needs_room = "Graph", ("topics",), "left", True
    gives_way = True
    keys = (("resource", "open"),)

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self._rows: Rows[ResourceRow] = Rows(
            resource_lines,
            lambda row: (row.resource.kind, row.resource.name),
            id="graph",
            empty="? nothing on the graph",
            action="app.command('resource')",
            wraps=True,
            columns=resource_columns,
        )
        self._drawn_inputs: object = None

    def compose(self) -> ComposeResult:
        yield self._rows

    @property
    def selected(self) -> ResourceRow | None:
        """Return the row under the cursor; None in an empty list."""
        return self._rows.item

    @property
    def focus_target(self) -> Widget:
        return self._rows

    def show(self, view: ScreenState) -> None:
        if not self.display and self._rows.items:  # Filled once while hidden, for keys typed ahead.
            return
        self.show_keys(view)
        if view.replay:
            self._rows.empty = NONE_RECORDED
        drawn = view.second, view.snapshot.resources
        if drawn != self._drawn_inputs:
            self._drawn_inputs = drawn
            rows = resource_rows(view)
            known = {row: row for row in self._rows.items}  # Equal rows are not laid out again.
            self._rows.show([known.get(row, row) for row in rows])
