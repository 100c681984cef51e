"""The panel of nodes: the nodes of the graph, and those of this process."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

from textual.app import ComposeResult
from textual.content import Content

from archo_tui.base.clock import time_of_day
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.panel import NONE_RECORDED, ListPanel, ScreenState
from archo_tui.screen.widgets.rows import Rows
from archo_tui.text.columns import QUIET, Columns, Text, column, crop, fit_columns, in_columns, pad
from archo_tui.text.nodes import NodeRow, node_rows
from archo_tui.text.state import PLAIN, STRONG, age_text

_MARK_WIDTH, _AGE_WIDTH, _NAME_WIDTH = 2, 5, 16  # Cells; of a name at least.
_RATE_WIDTH = 8  # Where there is room, so that no column moves between 9.9 and 10.0 Hz.
_NARROW = 30  # Such a panel is also low: a crashed node must not hide the others.
_KEYS = (("start_stop", "start/stop"), ("copy", "copy"))
# That it crashed, and in which line: what is said of it is read first.
_HEADS = re.compile(r"^(crashed: |not restarted: |line \d+: )+")
_STYLES = {STRONG: "bold", PLAIN: ""}


def _rate(row: NodeRow) -> str:
    return "" if row.state.rate is None else f"{row.state.rate:.1f} Hz"


def node_columns(rows: Sequence[NodeRow], width: int) -> Columns:
    """Return the widths of names, which have what the others leave, ages and rates."""
    rate = column(map(_rate, rows), 0, width)
    name = column((row.label for row in rows), 0, width)
    bounds = (1, name), (_AGE_WIDTH, _AGE_WIDTH), (rate, rate and max(rate, _RATE_WIDTH))
    room = width - _MARK_WIDTH
    widths = fit_columns(bounds, room, (0, 1, 2), gap=1)
    rest = room - sum(widths) - sum(map(bool, widths[1:]))
    return max(widths[0] + rest, 0), *widths[1:]


def node_titles(columns: Columns) -> str:
    """Return the line with the titles of the columns: `node    heard   rate`."""
    return f"{'':{_MARK_WIDTH}}{in_columns(('node', 'heard', 'rate'), columns, (1, 2), gap=1)}"


def node_lines(row: NodeRow, width: int, columns: Columns) -> list[Text]:
    """Return `● battery_monitor    0.4 s  1.0 Hz`, or the name and what is wrong with the node."""
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
    name = f"{glyph} {row.label:<{_NAME_WIDTH}} "
    if word and len(name + word) > width:
        room = max(width - _MARK_WIDTH, 10)
        more = textwrap.wrap(word, room)
        if width < _NARROW and len(more) > 1:
            more = [crop(_HEADS.sub("", word), room)]
        name = f"{glyph} {pad(row.label, room)}"
        return [(name, style), *((f"  {line}", style) for line in more)]
    if word:
        return [(name + word, style)]
    ago = "" if row.state.heard is None else age_text(row.second - row.state.heard)
    return [(f"{glyph} {in_columns((row.label, ago, _rate(row)), columns, (1, 2), gap=1)}", style)]


class NodesPanel(ListPanel[NodeRow]):
    """The list of nodes: when each was last received, how often it publishes, or what is wrong."""

    title_text, verbs, place = "Nodes", ("nodes",), "left"
    keys: Sequence[tuple[str, str]] = _KEYS

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self.rows: Rows[NodeRow] = Rows(
            node_lines,
            lambda row: row.name,
            id="nodes",
            empty="? no nodes on the graph",
            action="app.command('details')",
            wraps=True,
            columns=node_columns,
        )
        self._titles = Line(id="node-titles")  # The style sheet shows it where there is room.

    def compose(self) -> ComposeResult:
        yield self._titles
        yield self.rows

    @property
    def lines(self) -> int:
        """Return how many lines the whole list has, visible or not, with one for the titles."""
        return self.rows.virtual_size.height + 1

    def show(self, view: ScreenState) -> None:
        self.keys = (("restart", "restart"), *_KEYS) if view.restart_waits else _KEYS
        self.show_keys(view)
        self.show_narrowed("restart waits" if view.restart_waits else "")
        # Ages change once a second only, so that many messages cause little traffic.
        if self.is_news(view.second, view.hosted, len(view.snapshot.nodes)):
            self.rows.show(node_rows(view), NONE_RECORDED if view.replay else None)
        if self.rows.columns:
            titles = node_titles(self.rows.columns)
            self._titles.show(Content.styled(titles if self.rows.items else "", "bold"))
