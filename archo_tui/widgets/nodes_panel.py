"""The panel of nodes: the nodes of the graph, and those of this process."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

from textual.app import ComposeResult
from textual.content import Content
from textual.widget import Widget

from archo_tui.clock import time_of_day
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.text.nodes import NodeRow, node_rows
from archo_tui.text.state import PLAIN, STRONG, age_text
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text, column, crop, pad
from archo_tui.widgets.screen_state import NONE_RECORDED, ScreenState

_MARK_WIDTH, _AGE_WIDTH = 2, 6  # Cells.
_RATE_WIDTH, _SHORT_RATE_WIDTH = 9, 7  # Cells of ` 1.0 Hz` and of ` 1.0Hz`, with blanks before.
_NAME_WIDTH, _MIN_NAME_WIDTH = 16, 8  # Cells of a name; of one beside which a rate is shown.
_NARROW = 30  # Such a panel is also low: a crashed node must not hide the others.
_KEYS = (("start_stop", "start/stop"), ("copy", "copy"))
_STYLES = {STRONG: "bold", PLAIN: ""}


def node_columns(rows: Sequence[NodeRow], width: int) -> Columns:
    """Return the widths of the names and of the rates; 0 for the rates if they have no room."""
    room = width - _MARK_WIDTH - _AGE_WIDTH
    names = column((row.label for row in rows), _NAME_WIDTH, room)
    if names + _RATE_WIDTH <= room:
        return names, _RATE_WIDTH
    short = room - _SHORT_RATE_WIDTH
    if short < _MIN_NAME_WIDTH or all(row.state.rate is None for row in rows):
        return names, 0
    longest = column((row.label for row in rows), 0, room)
    if longest + _RATE_WIDTH <= room:  # Not even the longest name needs all of the usual width.
        return longest, _RATE_WIDTH
    return min(longest, short), _SHORT_RATE_WIDTH


def node_titles(width: int, columns: Columns) -> str:
    """Return the line with the titles of the columns: `node    heard   rate`."""
    numbers = f"{'heard':>5}{'rate':>{columns[1]}}" if columns[1] else "heard"
    room = max(width - _MARK_WIDTH - columns[0], 0)  # A hidden list has no width.
    return f"{'':{_MARK_WIDTH}}{'node':{columns[0]}}{numbers:>{room}}"


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
    name = f"{glyph} {pad(row.label, columns[0])} "
    if word and len(name + word) > width:
        room = max(width - _MARK_WIDTH, 10)
        more = textwrap.wrap(word, room)
        if width < _NARROW and len(more) > 1:
            more = [_crop_at_word(word, room)]
        name = f"{glyph} {pad(row.label, max(columns[0], room))}"  # No numbers stand beside it.
        return [(name, style), *((f"  {line}", style) for line in more)]
    if word:
        return [(name + word, style)]
    heard, rate = row.state.heard, row.state.rate
    ago = "" if heard is None else age_text(row.second - heard)
    rate_text = "" if rate is None else f"{rate:.1f} Hz"
    if columns[1] == _SHORT_RATE_WIDTH:
        rate_text = rate_text.replace(" ", "")
    numbers = f"{ago:>5}{rate_text:>{columns[1]}}" if columns[1] else f"{ago:>5}"
    room = max(width - _MARK_WIDTH - columns[0] - 1, 0)
    return [(f"{name}{numbers:>{room}}", style)]


def _crop_at_word(text: str, width: int) -> str:
    """Return what is wrong with a node in at most `width` cells, cut behind a whole word.

    That it crashed, and in which line, is left out: what is said of it is read first.
    """
    reason = re.sub(r"^(crashed: |not restarted: |line \d+: )+", "", text)
    cut = textwrap.shorten(reason, width, placeholder=" …")
    if 3 * len(cut) > 2 * width:
        return cut
    head = cut.removesuffix("…")
    if not head:
        return crop(reason, width)
    # A long word, as the name of a package, keeps its end: `no package my_r…faces`.
    word = reason[len(head) :].split(" ")[0].rstrip(":,")
    return f"{head}{pad(word, width - len(head))}".rstrip()


def _same_if_equal(before: NodeRow | None, now: NodeRow) -> NodeRow:
    return before if before is not None and before == now else now


class NodesPanel(Panel):
    """The list of nodes: when each was last received, how often it publishes, or what is wrong."""

    title_text, verbs, place = "Nodes", ("nodes",), "left"
    keys: Sequence[tuple[str, str]] = _KEYS

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self._rows: Rows[NodeRow] = Rows(
            node_lines,
            lambda row: row.name,
            id="nodes",
            empty="? no nodes on the graph",
            action="app.command('details')",
            wraps=True,
            columns=node_columns,
        )
        self._titles = Line(id="node-titles")  # The style sheet shows it where there is room.
        self._drawn_inputs: object = None

    def compose(self) -> ComposeResult:
        yield self._titles
        yield self._rows

    @property
    def lines(self) -> int:
        """Return how many lines the whole list has, visible or not, with one for the titles."""
        return self._rows.virtual_size.height + 1

    @property
    def selected(self) -> NodeRow | None:
        """Return the node under the cursor; None in an empty list."""
        return self._rows.item

    @property
    def shows_cursor(self) -> bool:
        """Return True once the operator has moved the focus or the cursor to the list."""
        return self._rows.shows_cursor

    @property
    def focus_target(self) -> Widget:
        return self._rows

    def show(self, view: ScreenState) -> None:
        self.keys = (("restart", "restart"), *_KEYS) if view.restart_waits else _KEYS
        self.show_keys(view)
        self.show_narrowed("restart waits" if view.restart_waits else "")
        if view.replay:
            self._rows.empty = NONE_RECORDED
        # Ages change once a second only, so that many messages cause little traffic.
        drawn = (view.second, view.hosted, len(view.snapshot.nodes))
        if drawn != self._drawn_inputs:
            self._drawn_inputs = drawn
            before = {row.name: row for row in self._rows.items}
            # Equal rows stay the same objects, so that only changed ones are laid out.
            self._rows.show([_same_if_equal(before.get(row.name), row) for row in node_rows(view)])
        if self._rows.columns:
            width = self._rows.scrollable_content_region.width
            titles = node_titles(width, self._rows.columns)
            self._titles.show(Content.styled(titles if self._rows.items else "", "bold"))
