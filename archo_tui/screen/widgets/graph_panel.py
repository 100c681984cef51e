"""The panel of the graph: topics, services and actions, with the nodes that have them."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.widgets.panel import NONE_RECORDED, ListPanel, ScreenState
from archo_tui.screen.widgets.rows import Rows
from archo_tui.text.columns import QUIET, Columns, Text, column, crop, fit_columns, in_columns
from archo_tui.text.graph import ResourceRow, resource_rows

_KIND_WIDTH = 7  # Cells of `service`.


def resource_columns(rows: Sequence[ResourceRow], width: int) -> Columns:
    """Return the widths of kinds, names, types, nodes and rates; of three if not all have room."""
    texts = zip(*((r.resource.name, r.types, r.who, r.rate) for r in rows), strict=True)
    name, types, who, rate = [column(each, 0, width) for each in texts] or (0, 0, 0, 0)
    kind = _KIND_WIDTH, _KIND_WIDTH
    bounds = kind, (name, name), (types, types), (who, width), (rate, rate)
    columns = fit_columns(bounds, width, (0, 4, 1, 2, 3))
    return (
        columns if columns[3] else fit_columns((kind, (1, width), (rate, rate)), width, (0, 2, 1))
    )


def resource_lines(row: ResourceRow, width: int, columns: Columns) -> list[Text]:
    """Return a row as `topic   /scan  sensor_msgs/msg/LaserScan  lidar  10.0 Hz`.

    Without room for all columns it takes two lines; mismatches of type or QoS stand below.
    """
    kind, name, style = row.resource.kind, row.resource.name, "" if row.resource.nodes else QUIET
    if len(columns) > 3:
        texts = kind, name, row.types, row.who, row.rate
        lines = [(in_columns(texts, columns, (4,)), style)]
    else:
        below = crop(f"  {row.short_types}  {row.who}", width)
        lines = [(in_columns((kind, name, row.rate), columns, (2,)), style), (below, QUIET)]
    wrong = (textwrap.wrap(text, max(width - 2, 10)) for text in row.resource.mismatches)
    return [*lines, *((f"  {line}", "bold") for part in wrong for line in part)]


class GraphPanel(ListPanel[ResourceRow]):
    """The list of topics, services and actions."""

    title_text, verbs, place, needs_room = "Graph", ("topics",), "left", True
    gives_way = True
    keys = (("resource", "open"),)

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self.rows: Rows[ResourceRow] = Rows(
            resource_lines,
            lambda row: (row.resource.kind, row.resource.name),
            id="graph",
            empty="? nothing on the graph",
            action="app.command('resource')",
            wraps=True,
            columns=resource_columns,
        )

    def show(self, view: ScreenState) -> None:
        if not self.display and self.rows.items:  # Filled once while hidden, for keys typed ahead.
            return
        self.show_keys(view)
        if self.is_news(view.second, view.snapshot.resources):
            self.rows.show(resource_rows(view), NONE_RECORDED if view.replay else None)
