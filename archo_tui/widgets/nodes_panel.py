"""Panel 5: the nodes of the graph, and those of this process."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from textual.app import ComposeResult
from textual.widget import Widget

from archo_tui.clock import time_of_day
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text, column, crop, pad
from archo_tui.widgets.screen_state import NONE_RECORDED, ScreenState
from archo_tui.words.nodes import NodeRow, node_rows
from archo_tui.words.state import PLAIN, STRONG, age_text

_MARK_WIDTH, _AGE_WIDTH, _RATE_WIDTH = 2, 6, 9  # Cells.
_NARROW = 30  # Such a panel is also low: a crashed node must not hide the others.
_STYLES = {STRONG: "bold", PLAIN: ""}


def node_columns(rows: Sequence[NodeRow], width: int) -> Columns:
    """Return the widths of the names, and of the rates if they fit."""
    room = width - _MARK_WIDTH - _AGE_WIDTH
    names = column((row.label for row in rows), 16, room)
    return names, _RATE_WIDTH if names + _RATE_WIDTH <= room else 0


def node_lines(row: NodeRow, width: int, columns: Columns) -> list[Text]:
    """Return `● battery_monitor    0.4 s  1.0 Hz`, or what is wrong with the node.

    For a node of the user's own, a line below names its file, and when it was saved.
    """
    hosted = row.hosted
    if hosted is None or not hosted.file:
        return _state_lines(row, width, columns)
    saved = f"  {hosted.file}, saved {time_of_day(hosted.saved)}"
    return [*_state_lines(row, width, columns), (saved, QUIET)]


def _state_lines(row: NodeRow, width: int, columns: Columns) -> list[Text]:
    glyph, word, tone = row.word()
    style = _STYLES.get(tone, QUIET)
    if row.is_faulty:
        word += " (enter: traceback)"
    name = f"{glyph} {pad(row.label, columns[0])} "
    if word and len(name + word) > width:
        more = textwrap.wrap(word, max(width - 2, 10))
        if width < _NARROW and len(more) > 1:
            more = [crop(word, width - 2)]
        return [(name, style), *((f"  {line}", style) for line in more)]
    if word:
        return [(name + word, style)]
    heard, rate = row.state.heard, row.state.rate
    ago = "" if heard is None else age_text(row.second - heard)
    rate_text = f" {rate:5.1f} Hz" if rate is not None else ""
    numbers = f"{ago:>5}{rate_text:<{columns[1]}}" if columns[1] else f"{ago:>5}"
    room = max(width - _MARK_WIDTH - columns[0] - 1, 0)
    return [(f"{name}{numbers:>{room}}", style)]


def _same_if_equal(before: NodeRow | None, now: NodeRow) -> NodeRow:
    return before if before is not None and before == now else now


class NodesPanel(Panel):
    """The list of nodes: when each was last received, how often it publishes, or what is wrong."""

    number, title_text = 5, "Nodes"
    keys = (("start_stop", "start/stop"), ("copy", "copy"))

    def __init__(self) -> None:
        super().__init__()
        self._rows: Rows[NodeRow] = Rows(
            node_lines,
            lambda row: row.name,
            id="nodes",
            empty="? no nodes on the graph",
            action="app.command('details')",
            wraps=True,
            columns=node_columns,
        )
        self._drawn_inputs: object = None

    def compose(self) -> ComposeResult:
        yield self._rows

    @property
    def lines(self) -> int:
        """Return how many lines the list needs."""
        return self._rows.virtual_size.height

    @property
    def selected(self) -> NodeRow | None:
        """Return the node under the cursor."""
        return self._rows.item

    @property
    def shows_cursor(self) -> bool:
        """Return True once the operator has come to the list."""
        return self._rows.shows_cursor

    @property
    def focus_target(self) -> Widget:
        return self._rows

    def show(self, view: ScreenState) -> None:
        self.show_keys(view)
        if view.replay:
            self._rows.empty = NONE_RECORDED
        # Ages change once a second only, so that many messages cause little traffic.
        drawn = (view.second, view.hosted, len(view.snapshot.nodes))
        if drawn != self._drawn_inputs:
            self._drawn_inputs = drawn
            before = {row.name: row for row in self._rows.items}
            # Equal rows stay the same objects, so that only changed ones are laid out.
            self._rows.show([_same_if_equal(before.get(row.name), row) for row in node_rows(view)])
