"""Panel 5: who is on the graph, and how the nodes of this process are doing."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from textual.app import ComposeResult
from textual.widget import Widget

from archo_tui.clock import time_of_day
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text, column, crop, pad
from archo_tui.widgets.shown import NONE_RECORDED, Shown
from archo_tui.words.nodes import NodeRow, node_rows
from archo_tui.words.state import PLAIN, STRONG, age_text

_MARK, _AGE, _RATE = 2, 6, 9  # columns
_NARROW = 30  # cells below which the panel is low, too: one crashed node must not hide the others
_STYLES = {STRONG: "bold", PLAIN: ""}


def node_columns(rows: Sequence[NodeRow], width: int) -> Columns:
    """Of the names, and of the rates where names leave room for them."""
    room = width - _MARK - _AGE
    names = column((row.name.lstrip("/") for row in rows), 16, room)
    return names, _RATE if names + _RATE <= room else 0


def node_lines(row: NodeRow, width: int, columns: Columns) -> list[Text]:
    """`● battery_monitor    0.4 s  1.0 Hz`, or in words what is wrong with it.

    Below that the file of a node of the user's own, and when it was saved.
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
    name = f"{glyph} {pad(row.name.lstrip('/'), columns[0])} "
    if word and len(name + word) > width:
        more = textwrap.wrap(word, max(width - 2, 10))
        if width < _NARROW and len(more) > 1:
            more = [crop(word, width - 2)]
        return [(name, style), *((f"  {line}", style) for line in more)]
    if word:
        return [(name + word, style)]
    heard, rate = row.state.heard, row.state.rate
    ago = "" if heard is None else age_text(row.second - heard)
    often = f" {rate:5.1f} Hz" if rate is not None else ""
    numbers = f"{ago:>5}{often:<{columns[1]}}" if columns[1] else f"{ago:>5}"
    room = max(width - _MARK - columns[0] - 1, 0)
    return [(f"{name}{numbers:>{room}}", style)]


def _kept(before: NodeRow | None, now: NodeRow) -> NodeRow:
    return before if before is not None and before == now else now


class NodesPanel(Panel):
    """One line a node: when it was last heard and how often it publishes, or what is wrong."""

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
        self._drawn: object = None

    def compose(self) -> ComposeResult:
        yield self._rows

    @property
    def lines(self) -> int:
        """How many it needs."""
        return self._rows.virtual_size.height

    @property
    def selected(self) -> NodeRow | None:
        """The node under the cursor."""
        return self._rows.item

    @property
    def shows_cursor(self) -> bool:
        """False until a person came to the list."""
        return self._rows.shows_cursor

    @property
    def operated(self) -> Widget:
        return self._rows

    def show(self, view: Shown) -> None:
        self.show_keys(view)
        if view.replay:
            self._rows.empty = NONE_RECORDED
        # once a second is enough for ages: a chatty robot must not become a chatty terminal
        drawn = (view.second, view.hosted, len(view.snapshot.nodes))
        if drawn != self._drawn:
            self._drawn = drawn
            before = {row.name: row for row in self._rows.items}
            # those that look as before stay the same objects: of a crowd only few are drawn
            self._rows.show([_kept(before.get(row.name), row) for row in node_rows(view)])
