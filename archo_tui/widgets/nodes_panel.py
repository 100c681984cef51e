"""Panel 5: who is on the graph, and how the nodes of this process are doing."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import NamedTuple

from textual.app import ComposeResult
from textual.widget import Widget

from archo_tui.clock import time_of_day
from archo_tui.robot.state import Hosted, Life, NodeState, Snapshot
from archo_tui.state_text import age
from archo_tui.station import View
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text, column, pad
from archo_tui.widgets.shown import Shown

_MARK, _AGE, _RATE = 2, 6, 9  # columns


class NodeRow(NamedTuple):
    """One line of the panel: a node that is on the graph, runs here, or both."""

    state: NodeState
    hosted: Hosted | None
    second: float  # monotonic s of the last tick, 0 without an age: ages need not be livelier

    @property
    def name(self) -> str:
        """Fully qualified."""
        return self.state.name

    def word(self) -> tuple[str, str, str]:
        """Glyph, what is wrong, and style; nothing is said while nothing is wrong."""
        life = Life.UP if self.hosted is None else self.hosted.life
        if life == Life.CRASHED and self.hosted is not None:
            return "✗", f"crashed: {self.hosted.error} (enter: traceback)", "bold"
        if life == Life.UP and self.hosted is not None and self.hosted.error:
            return "✗", f"not restarted: {self.hosted.error} (enter: traceback)", "bold"
        if life == Life.STUCK:
            return "✗", life.value, "bold"
        if life == Life.STOPPED:
            return "○", life.value, QUIET
        if self.state.is_silent(self.second) and self.state.heard is not None:
            return "?", f"silent for {age(self.second - self.state.heard)}", QUIET
        return "●", "", ""

    def details(self, now: float, snapshot: Snapshot) -> str:
        """Everything that is known of the node, for reading."""
        glyph, word, _ = self.word()
        heard, rate = self.state.heard, self.state.rate
        often = "--" if rate is None else f"{rate:.1f} Hz"
        runs = self.hosted is None or self.hosted.life == Life.UP
        if rate is not None and (self.state.is_silent(now) or not runs):
            often = f"nothing now, {often} before"
        parameters = sum(p.node == self.name for p in snapshot.parameters)
        lines = [
            f"{glyph} {word.replace(' (enter: traceback)', '') or 'up'}",
            f"runs        {'in this process' if self.hosted else 'in another process'}",
            f"last heard  {'--' if heard is None else age(now - heard) + ' ago'}",
            f"publishes   {often}",
            f"parameters  {parameters}",
        ]
        if self.hosted is not None and self.hosted.traceback:
            lines += ["", self.hosted.traceback]
        return "\n".join(lines)


def node_rows(view: View) -> tuple[NodeRow, ...]:
    """The nodes of the graph and of this process, by name."""
    hosted = {node.name: node for node in view.hosted}
    states = {node.name: node for node in view.snapshot.nodes}

    def row(name: str) -> NodeRow:
        state = states.get(name, NodeState(name))
        return NodeRow(state, hosted.get(name), 0.0 if state.heard is None else view.second)

    return tuple(map(row, sorted(states.keys() | hosted.keys())))


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
    glyph, word, style = row.word()
    name = f"{glyph} {pad(row.name.lstrip('/'), columns[0])} "
    if word and len(name + word) > width:
        more = textwrap.wrap(word, max(width - 2, 10))
        return [(name, style), *((f"  {line}", style) for line in more)]
    if word:
        return [(name + word, style)]
    heard, rate = row.state.heard, row.state.rate
    ago = "" if heard is None else age(row.second - heard)
    often = f" {rate:5.1f} Hz" if rate is not None and columns[1] else ""
    return [(f"{name}{ago:>5}{often}", style)]


def _kept(before: NodeRow | None, now: NodeRow) -> NodeRow:
    return before if before is not None and before == now else now


class NodesPanel(Panel):
    """One line a node: when it was last heard and how often it publishes, or what is wrong."""

    number, title_text = 5, "Nodes"
    keys = (("start_stop", "start/stop"), ("copy_node", "copy"))

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
    def selected(self) -> NodeRow | None:
        """The node under the cursor."""
        return self._rows.item

    @property
    def operated(self) -> Widget:
        return self._rows

    def show(self, view: Shown) -> None:
        self.show_keys(view)
        # once a second is enough for ages: a chatty robot must not become a chatty terminal
        drawn = (view.second, view.hosted, len(view.snapshot.nodes))
        if drawn != self._drawn:
            self._drawn = drawn
            before = {row.name: row for row in self._rows.items}
            # those that look as before stay the same objects: of a crowd only few are drawn
            self._rows.show([_kept(before.get(row.name), row) for row in node_rows(view)])
